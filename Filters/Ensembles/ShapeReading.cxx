// SPDX-License-Identifier: BSD-3-Clause
#include "ShapeReading.h"

#include "DataObjects.h"

#include "Core/Common/Errors.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

namespace surfsynth
{

std::vector<MovedCopy> MovedCopies(vtkDataObject* shapes)
{
  std::vector<MovedCopy> copies;
  const auto add = [&copies](vtkDataObject* data, const std::string& name) {
    auto* copy = vtkPointSet::SafeDownCast(data);
    if (!copy)
    {
      throw InvalidInput(
        name + " of the shapes is a " + data->GetClassName() + "; expected copies of the input with moved points.");
    }
    if (!IsEmpty(copy))
    {
      copies.push_back({ copy, name });
    }
  };
  auto* tree = vtkDataObjectTree::SafeDownCast(shapes);
  if (!tree)
  {
    add(shapes, "The dataset");
    return copies;
  }
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem()) // null leaves are passed over
  {
    add(place->GetCurrentDataObject(), "Block " + std::to_string(place->GetCurrentFlatIndex()));
  }
  return copies;
}

PointMatrix PointsOfCopy(const MovedCopy& shape, vtkPointSet* body, const PointMatrix& rest)
{
  const vtkIdType count = shape.Copy->GetNumberOfPoints();
  if (count != body->GetNumberOfPoints())
  {
    throw InvalidInput(shape.Name + " of the shapes has " + std::to_string(count) + " points and the input has " +
      std::to_string(body->GetNumberOfPoints()) + "; expected copies of the input with moved points.");
  }
  PointMatrix points = rest;
  for (vtkIdType v = 0; v < count; ++v)
  {
    Eigen::RowVector3d point;
    shape.Copy->GetPoint(v, point.data());
    if (rest.row(v).allFinite() && !point.allFinite())
    {
      throw InvalidInput(shape.Name + " of the shapes has coordinates that are not finite, the first at point " +
        std::to_string(v) + "; expected finite ones.");
    }
    points.row(v) = rest.row(v).allFinite() ? point : Eigen::RowVector3d(rest.row(v));
  }
  return points;
}

} // namespace surfsynth
