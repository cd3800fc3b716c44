// SPDX-License-Identifier: BSD-3-Clause
#include "CoarseSurfaces.h"

#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"

#include <vtkAdaptiveSubdivisionFilter.h>
#include <vtkBoundingBox.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr vtkIdType MaximumNumberOfRefinedTriangles = 4000000;
/// The default correlation range over the longest side of the box, as in MaternField.
constexpr double DefaultRangeOverSize = 0.2;

/// The longest edge of the triangles of @p surface; not finite where a point is not.
double LongestPolygonEdge(vtkPolyData* surface)
{
  double longest = 0.0;
  const auto cell = vtkSmartPointer<vtkCellArrayIterator>::Take(surface->GetPolys()->NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    cell->GetCurrentCell(size, ids);
    for (vtkIdType k = 0; k < size; ++k)
    {
      std::array<double, 3> a{};
      std::array<double, 3> b{};
      surface->GetPoint(ids[k], a.data());
      surface->GetPoint(ids[(k + 1) % size], b.data());
      const double squared = vtkMath::Distance2BetweenPoints(a.data(), b.data());
      longest = squared <= longest ? longest : squared; // a NaN stays
    }
  }
  return std::sqrt(longest);
}

/// True for a surface that the filter accepts: what is wrong with another one is said with the ids of the caller's cells.
bool IsValidSurface(vtkPolyData* surface)
{
  try
  {
    ToSurface(surface, MeshRequirements());
    return true;
  }
  catch (const InvalidInput&)
  {
    return false;
  }
}

/// Replaces the point array @p name, when it is there with one component, by 1 where its numbers are at least @p least in
/// size and 0 elsewhere, as numbers that can be interpolated. Those that are not finite stay.
void ReplaceMask(vtkPolyData* surface, const std::string& name, double least)
{
  vtkDataArray* array = name.empty() ? nullptr : surface->GetPointData()->GetArray(name.c_str());
  if (!array || array->GetNumberOfComponents() != 1)
  {
    return;
  }
  vtkNew<vtkDoubleArray> mask;
  mask->SetName(name.c_str());
  mask->SetNumberOfTuples(array->GetNumberOfTuples());
  for (vtkIdType k = 0; k < array->GetNumberOfTuples(); ++k)
  {
    const double number = array->GetComponent(k, 0);
    mask->SetValue(k, !std::isfinite(number) ? number : std::abs(number) >= least ? 1.0 : 0.0);
  }
  surface->GetPointData()->AddArray(mask);
}

/// Name of the axes while a surface is divided.
constexpr const char* NameOfAxes = "SurfaceSynthesisAxes";

/// Adds axes d d^T / |d| of the point array @p name, when it is there with three components: six components for each point.
void AddAxes(vtkPolyData* surface, const std::string& name)
{
  vtkDataArray* array = name.empty() ? nullptr : surface->GetPointData()->GetArray(name.c_str());
  if (!array || array->GetNumberOfComponents() != 3)
  {
    return;
  }
  vtkNew<vtkDoubleArray> axes;
  axes->SetName(NameOfAxes);
  axes->SetNumberOfComponents(6);
  axes->SetNumberOfTuples(array->GetNumberOfTuples());
  for (vtkIdType p = 0; p < array->GetNumberOfTuples(); ++p)
  {
    std::array<double, 3> d{};
    array->GetTuple(p, d.data());
    const double length = std::max(vtkMath::Norm(d.data()), std::numeric_limits<double>::min());
    axes->SetTuple6(p, d[0] * d[0] / length, d[0] * d[1] / length, d[0] * d[2] / length, d[1] * d[1] / length,
      d[1] * d[2] / length, d[2] * d[2] / length);
  }
  surface->GetPointData()->AddArray(axes);
}

/// Replaces the directions of the points from @p first on by the main axes, which are removed.
void TakeAxes(vtkPolyData* surface, const std::string& name, vtkIdType first)
{
  vtkDataArray* axes = surface->GetPointData()->GetArray(NameOfAxes);
  vtkDataArray* array = axes ? surface->GetPointData()->GetArray(name.c_str()) : nullptr;
  if (!array)
  {
    return;
  }
  vtkNew<vtkDoubleArray> directions;
  directions->DeepCopy(array);
  directions->SetName(name.c_str());
  for (vtkIdType p = first; p < array->GetNumberOfTuples(); ++p)
  {
    std::array<double, 6> m{};
    axes->GetTuple(p, m.data());
    Eigen::Matrix3d matrix;
    matrix << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> pairs(matrix);
    const Eigen::Vector3d axis = pairs.eigenvalues()[2] * pairs.eigenvectors().col(2);
    directions->SetTuple3(p, axis[0], axis[1], axis[2]);
  }
  surface->GetPointData()->AddArray(directions);
  surface->GetPointData()->RemoveArray(NameOfAxes);
}

/// The refined surface, or null when it is fine enough, or broken.
vtkSmartPointer<vtkPolyData> RefinedSurface(
  vtkPolyData* surface, double range, const std::string& mask, const std::string& directions)
{
  if (surface->GetNumberOfPoints() == 0 || !IsValidSurface(surface))
  {
    return nullptr;
  }
  if (range <= 0.0)
  {
    range = DefaultRangeOverSize * vtkBoundingBox(surface->GetBounds()).GetMaxLength();
  }
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(surface);
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->Update();
  const double longest = LongestPolygonEdge(triangles->GetOutput());
  if (!std::isfinite(longest) || !std::isfinite(range) || longest <= range / 3.0)
  {
    return nullptr;
  }
  vtkNew<vtkPolyData> coarse;
  coarse->ShallowCopy(triangles->GetOutput());
  ReplaceMask(coarse, mask, std::numeric_limits<double>::denorm_min());
  AddAxes(coarse, directions);
  vtkNew<vtkAdaptiveSubdivisionFilter> subdivision;
  subdivision->SetInputData(coarse);
  subdivision->SetMaximumEdgeLength(range / 4.0);
  subdivision->SetMaximumTriangleArea(VTK_DOUBLE_MAX);
  subdivision->SetMaximumNumberOfTriangles(MaximumNumberOfRefinedTriangles);
  subdivision->Update();
  auto refined = vtkSmartPointer<vtkPolyData>::New();
  refined->ShallowCopy(subdivision->GetOutput());
  ReplaceMask(refined, mask, 1.0);
  TakeAxes(refined, directions, coarse->GetNumberOfPoints());
  return refined;
}
} // namespace

vtkSmartPointer<vtkDataObject> RefineCoarseSurfaces(
  vtkDataObject* input, double range, const std::string& mask, const std::string& directions)
{
  if (auto* surface = vtkPolyData::SafeDownCast(input))
  {
    const vtkSmartPointer<vtkPolyData> refined = RefinedSurface(surface, range, mask, directions);
    return refined ? vtkSmartPointer<vtkDataObject>(refined) : vtkSmartPointer<vtkDataObject>(input);
  }
  auto* tree = vtkDataObjectTree::SafeDownCast(input);
  if (!tree)
  {
    return input;
  }
  const auto copy = vtkSmartPointer<vtkDataObjectTree>::Take(tree->NewInstance());
  copy->ShallowCopy(tree);
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    auto* leaf = vtkPolyData::SafeDownCast(place->GetCurrentDataObject());
    if (const vtkSmartPointer<vtkPolyData> refined = leaf ? RefinedSurface(leaf, range, mask, directions) : nullptr)
    {
      copy->SetDataSet(place, refined);
    }
  }
  return copy;
}

} // namespace surfsynth
