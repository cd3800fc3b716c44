// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceArrays.h"

#include "Core/Common/Parallel.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkGenericCell.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStaticCellLocator.h>
#include <vtkVariant.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>

namespace surfsynth
{

namespace
{
constexpr std::int64_t PlaceGrain = 1024;

bool KeepsItsMeaning(vtkDataSetAttributes* source, int k)
{
  const int role = source->IsArrayAnAttribute(k);
  vtkAbstractArray* array = source->GetAbstractArray(k);
  const char* name = array->GetName();
  const bool ghosts = name && std::strcmp(name, vtkDataSetAttributes::GhostArrayName()) == 0;
  return !ghosts && role != vtkDataSetAttributes::GLOBALIDS && role != vtkDataSetAttributes::PEDIGREEIDS;
}

/// Adds to @p target an array like each of those of @p source that stay meaningful and have at least @p wanted tuples,
/// filled by @p fill(old, made, role).
void Carry(vtkDataSetAttributes* source, vtkIdType wanted, vtkIdType tuples, vtkDataSetAttributes* target,
  const std::function<void(vtkAbstractArray*, vtkAbstractArray*, int)>& fill)
{
  for (int k = 0; k < source->GetNumberOfArrays(); ++k)
  {
    vtkAbstractArray* old = source->GetAbstractArray(k);
    if (!KeepsItsMeaning(source, k) || old->GetNumberOfTuples() < wanted)
    {
      continue; // an array that is too short has no value for every point
    }
    const auto made = vtkSmartPointer<vtkAbstractArray>::Take(old->NewInstance());
    made->SetName(old->GetName());
    made->SetNumberOfComponents(old->GetNumberOfComponents());
    made->CopyComponentNames(old);
    made->SetNumberOfTuples(tuples);
    const int role = source->IsArrayAnAttribute(k);
    fill(old, made, role);
    const int place = target->AddArray(made);
    if (role >= 0)
    {
      target->SetActiveAttribute(place, role);
    }
  }
}

int LargestOf(const Eigen::Vector3d& weights)
{
  int corner = 0;
  weights.maxCoeff(&corner);
  return corner;
}

void InterpolateTuple(vtkDataArray* old, const TriangleMesh& mesh, const SurfacePlace& place, bool isNormal,
  std::vector<double>& tuple, std::vector<double>& corner)
{
  std::fill(tuple.begin(), tuple.end(), 0.0);
  for (int k = 0; k < 3; ++k)
  {
    if (place.Weights[k] > 0.0) // a corner that does not count must not spread its NaN
    {
      old->GetTuple(mesh.Triangles(place.Triangle, k), corner.data());
      std::transform(tuple.begin(), tuple.end(), corner.begin(), tuple.begin(),
        [&](double sum, double value) { return sum + place.Weights[k] * value; });
    }
  }
  const double length = isNormal ? Eigen::Map<Eigen::VectorXd>(tuple.data(), tuple.size()).norm() : 1.0;
  if (isNormal && length > 0.0)
  {
    std::for_each(tuple.begin(), tuple.end(), [&](double& value) { value /= length; });
  }
}

/// Comparison of two tuples of the arrays that are carried over.
class TupleComparison
{
public:
  explicit TupleComparison(vtkDataSetAttributes* source, vtkIdType points)
  {
    for (int k = 0; k < source->GetNumberOfArrays(); ++k)
    {
      vtkAbstractArray* array = source->GetAbstractArray(k);
      if (!KeepsItsMeaning(source, k) || array->GetNumberOfTuples() < points)
      {
        continue;
      }
      double tolerance = 0.0;
      if (auto* numbers = vtkDataArray::SafeDownCast(array))
      {
        for (int c = 0; c < numbers->GetNumberOfComponents(); ++c)
        {
          const double* range = numbers->GetRange(c);
          tolerance = std::max(tolerance, 1e-6 * (range[1] - range[0]));
        }
      }
      this->Arrays.push_back({ array, tolerance });
    }
  }

  bool Same(vtkIdType a, vtkIdType b) const
  {
    return std::all_of(this->Arrays.begin(), this->Arrays.end(), [a, b](const Compared& compared) {
      const int components = compared.Array->GetNumberOfComponents();
      auto* numbers = vtkDataArray::SafeDownCast(compared.Array);
      for (int c = 0; c < components; ++c)
      {
        const bool same = numbers
          ? std::abs(numbers->GetComponent(a, c) - numbers->GetComponent(b, c)) <= compared.Tolerance
          : compared.Array->GetVariantValue(a * components + c) == compared.Array->GetVariantValue(b * components + c);
        if (!same)
        {
          return false;
        }
      }
      return true;
    });
  }

private:
  struct Compared
  {
    vtkAbstractArray* Array;
    double Tolerance;
  };
  std::vector<Compared> Arrays;
};
} // namespace

void SetGeometry(vtkPolyData* output, const TriangleMesh& mesh, bool doublePrecision)
{
  output->Initialize();
  vtkNew<vtkPoints> points;
  points->SetDataType(doublePrecision ? VTK_DOUBLE : VTK_FLOAT);
  points->SetNumberOfPoints(mesh.NumberOfPoints());
  if (doublePrecision)
  {
    std::copy_n(mesh.Points.data(), mesh.Points.size(), vtkDoubleArray::SafeDownCast(points->GetData())->GetPointer(0));
  }
  else
  {
    std::copy_n(mesh.Points.data(), mesh.Points.size(), vtkFloatArray::SafeDownCast(points->GetData())->GetPointer(0));
  }
  output->SetPoints(points);
  const vtkIdType count = mesh.NumberOfTriangles();
  vtkNew<vtkIdTypeArray> offsets;
  offsets->SetNumberOfValues(count + 1);
  for (vtkIdType f = 0; f <= count; ++f)
  {
    offsets->SetValue(f, 3 * f);
  }
  vtkNew<vtkIdTypeArray> ids;
  ids->SetNumberOfValues(3 * count);
  std::copy_n(mesh.Triangles.data(), 3 * count, ids->GetPointer(0));
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  output->SetPolys(cells);
}

bool HasDoublePoints(vtkPolyData* surface)
{
  return surface->GetPoints() && surface->GetPoints()->GetDataType() == VTK_DOUBLE;
}

void DropNormals(vtkDataSet* surface)
{
  for (vtkDataSetAttributes* data : { static_cast<vtkDataSetAttributes*>(surface->GetPointData()),
         static_cast<vtkDataSetAttributes*>(surface->GetCellData()) })
  {
    data->SetNormals(nullptr); // removes the array
    data->RemoveArray("Normals");
  }
}

void SetActiveWhereNone(vtkDataSetAttributes* data, const char* name)
{
  if (!data->GetScalars())
  {
    data->SetActiveScalars(name);
  }
  vtkDataArray* array = data->GetArray(name);
  if (array && array->GetNumberOfComponents() == 3 && !data->GetVectors())
  {
    data->SetActiveVectors(name);
  }
}

class NearestPlaces::Internals
{
public:
  explicit Internals(const TriangleMesh& mesh)
    : Mesh(mesh)
  {
    SetGeometry(this->Surface, mesh, true);
    this->Locator->SetDataSet(this->Surface);
    this->Locator->BuildLocator();
  }

  const TriangleMesh& Mesh;
  vtkNew<vtkPolyData> Surface;
  vtkNew<vtkStaticCellLocator> Locator;
};

NearestPlaces::NearestPlaces(const TriangleMesh& mesh)
  : Impl(std::make_unique<Internals>(mesh))
{}

NearestPlaces::~NearestPlaces() = default;

std::vector<SurfacePlace> NearestPlaces::Find(const PointMatrix& points) const
{
  std::vector<SurfacePlace> places(static_cast<std::size_t>(points.rows()));
  ParallelFor(points.rows(), PlaceGrain, [&](std::int64_t begin, std::int64_t end) {
    vtkNew<vtkGenericCell> cell;
    for (std::int64_t p = begin; p < end; ++p)
    {
      double nearest[3];
      vtkIdType triangle = -1;
      int subId = 0;
      double squaredDistance = 0.0;
      this->Impl->Locator->FindClosestPoint(points.row(p).data(), nearest, cell, triangle, subId, squaredDistance);
      const Index f = triangle >= 0 ? static_cast<Index>(triangle) : 0;
      places[p] = NearestOnTriangle(this->Impl->Mesh, f, points.row(p).transpose());
    }
  });
  return places;
}

std::vector<SurfacePlace> FindNearestPlaces(const TriangleMesh& mesh, const PointMatrix& points)
{
  return NearestPlaces(mesh).Find(points);
}

void InterpolateArrays(vtkDataSetAttributes* source, const TriangleMesh& mesh, const std::vector<SurfacePlace>& places,
  vtkDataSetAttributes* target)
{
  const auto count = static_cast<vtkIdType>(places.size());
  const auto fill = [&](vtkAbstractArray* old, vtkAbstractArray* made, int role) {
    auto* numbers = vtkDataArray::SafeDownCast(old);
    const bool isReal = numbers && (old->GetDataType() == VTK_FLOAT || old->GetDataType() == VTK_DOUBLE);
    std::vector<double> tuple(static_cast<std::size_t>(old->GetNumberOfComponents()));
    std::vector<double> corner(tuple.size());
    for (vtkIdType p = 0; p < count; ++p)
    {
      if (isReal)
      {
        InterpolateTuple(numbers, mesh, places[p], role == vtkDataSetAttributes::NORMALS, tuple, corner);
        vtkDataArray::SafeDownCast(made)->SetTuple(p, tuple.data());
      }
      else
      {
        made->SetTuple(p, mesh.Triangles(places[p].Triangle, LargestOf(places[p].Weights)), old);
      }
    }
  };
  const std::int64_t named = mesh.Triangles.size() > 0 ? std::int64_t(mesh.Triangles.maxCoeff()) + 1 : 0;
  Carry(source, std::max<std::int64_t>(mesh.NumberOfPoints(), named), count, target, fill);
}

void PickArrays(vtkDataSetAttributes* source, const std::vector<std::int64_t>& ids, vtkDataSetAttributes* target)
{
  const auto fill = [&](vtkAbstractArray* old, vtkAbstractArray* made, int) {
    for (std::size_t k = 0; k < ids.size(); ++k)
    {
      made->SetTuple(static_cast<vtkIdType>(k), static_cast<vtkIdType>(ids[k]), old);
    }
  };
  const std::int64_t wanted = ids.empty() ? 0 : *std::max_element(ids.begin(), ids.end()) + 1;
  Carry(source, wanted, static_cast<vtkIdType>(ids.size()), target, fill);
}

std::vector<Index> AttributeClasses(vtkPolyData* surface, const PointMatrix& points)
{
  const TupleComparison tuples(surface->GetPointData(), points.rows());
  std::vector<Index> order(static_cast<std::size_t>(points.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto coordinates = [&](Index p) { return std::make_tuple(points(p, 0), points(p, 1), points(p, 2), p); };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return coordinates(a) < coordinates(b); });
  std::vector<Index> classes(order.size());
  for (std::size_t begin = 0; begin < order.size();)
  {
    std::size_t end = begin + 1;
    while (end < order.size() && points.row(order[end]) == points.row(order[begin]))
    {
      ++end;
    }
    for (std::size_t k = begin; k < end; ++k)
    {
      const auto same = [&](Index other) { return classes[other] == other && tuples.Same(other, order[k]); };
      classes[order[k]] = order[k];
      classes[order[k]] = *std::find_if(order.begin() + begin, order.begin() + k, same);
    }
    begin = end;
  }
  return classes;
}

} // namespace surfsynth
