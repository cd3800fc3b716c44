// SPDX-License-Identifier: BSD-3-Clause
#include "ShapeReading.h"

#include "DataObjects.h"

#include "Core/Common/Errors.h"

#include <vtkDataObject.h>
#include <vtkPointSet.h>

namespace surfsynth
{

std::vector<MovedCopy> MovedCopies(vtkDataObject* shapes, vtkPointSet* body)
{
  std::vector<MovedCopy> copies;
  for (const Leaf& leaf : LeavesOf(shapes))
  {
    const std::string name = leaf.Place.empty() ? "The dataset" : leaf.Place;
    auto* copy = vtkPointSet::SafeDownCast(leaf.Data);
    if (!copy)
    {
      throw InvalidInput(name + " of the shapes is a " + leaf.Data->GetClassName() +
        "; expected copies of the input with moved points.");
    }
    if (copy->GetNumberOfPoints() != body->GetNumberOfPoints())
    {
      throw InvalidInput(name + " of the shapes has " + std::to_string(copy->GetNumberOfPoints()) +
        " points and the input has " + std::to_string(body->GetNumberOfPoints()) +
        "; expected copies of the input with moved points.");
    }
    copies.push_back({ copy, name });
  }
  if (copies.empty())
  {
    throw InvalidInput("The shapes are empty; expected copies of the input with moved points.");
  }
  return copies;
}

PointMatrix PointsOfCopy(const MovedCopy& shape, const PointMatrix& rest)
{
  PointMatrix points = rest;
  for (vtkIdType v = 0; v < rest.rows(); ++v)
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
