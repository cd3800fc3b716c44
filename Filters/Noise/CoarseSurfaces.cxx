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

/// The refined surface, or null when it is fine enough, or broken.
vtkSmartPointer<vtkPolyData> RefinedSurface(vtkPolyData* surface, double range, const std::string& mask)
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
  vtkNew<vtkAdaptiveSubdivisionFilter> subdivision;
  subdivision->SetInputData(coarse);
  subdivision->SetMaximumEdgeLength(range / 4.0);
  subdivision->SetMaximumTriangleArea(VTK_DOUBLE_MAX);
  subdivision->SetMaximumNumberOfTriangles(MaximumNumberOfRefinedTriangles);
  subdivision->Update();
  auto refined = vtkSmartPointer<vtkPolyData>::New();
  refined->ShallowCopy(subdivision->GetOutput());
  ReplaceMask(refined, mask, 1.0);
  return refined;
}
} // namespace

vtkSmartPointer<vtkDataObject> RefineCoarseSurfaces(vtkDataObject* input, double range, const std::string& mask)
{
  if (auto* surface = vtkPolyData::SafeDownCast(input))
  {
    const vtkSmartPointer<vtkPolyData> refined = RefinedSurface(surface, range, mask);
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
    if (const vtkSmartPointer<vtkPolyData> refined = leaf ? RefinedSurface(leaf, range, mask) : nullptr)
    {
      copy->SetDataSet(place, refined);
    }
  }
  return copy;
}

} // namespace surfsynth
