// SPDX-License-Identifier: BSD-3-Clause
#include "ShapeReading.h"

#include "DataObjects.h"

#include "Core/Common/Errors.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <algorithm>

namespace surfsynth
{

namespace
{
using Children = std::vector<vtkDataObject*>;

/// The children of a composite dataset, null ones too; none of a dataset.
Children ChildrenOf(vtkDataObject* data)
{
  Children children;
  if (auto* tree = vtkDataObjectTree::SafeDownCast(data))
  {
    const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    place->VisitOnlyLeavesOff();
    place->TraverseSubTreeOff();
    place->SkipEmptyNodesOff();
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      children.push_back(place->GetCurrentDataObject());
    }
  }
  return children;
}

/// Calls visit(flat index, block, what stands in its place) for the blocks of @p input, in order, while it returns true.
template <typename Visit>
bool VisitBlocks(vtkDataObject* input, vtkDataObject* shapes, unsigned int& flatIndex, const Visit& visit)
{
  if (!visit(flatIndex, input, shapes))
  {
    return false;
  }
  const Children blocks = ChildrenOf(input), places = ChildrenOf(shapes);
  for (std::size_t k = 0; k < blocks.size(); ++k)
  {
    ++flatIndex;
    if (!VisitBlocks(blocks[k], k < places.size() ? places[k] : nullptr, flatIndex, visit))
    {
      return false;
    }
  }
  return true;
}
} // namespace

vtkDataObject* ShapesOfBlock(vtkDataObject* input, vtkDataObject* shapes, unsigned int flatIndex)
{
  vtkDataObject* found = nullptr;
  unsigned int first = 0;
  VisitBlocks(input, shapes, first, [&](unsigned int index, vtkDataObject*, vtkDataObject* place) {
    found = index == flatIndex ? place : nullptr;
    return index != flatIndex;
  });
  return found;
}

ShapeCounts CountShapes(vtkDataObject* input, vtkDataObject* shapes)
{
  ShapeCounts counts;
  std::size_t placed = 0;
  unsigned int first = 0;
  VisitBlocks(input, shapes, first, [&](unsigned int, vtkDataObject* block, vtkDataObject* place) {
    if (!vtkDataObjectTree::SafeDownCast(block)) // null where another MPI rank has it
    {
      const std::size_t here = LeavesOf(place).size();
      placed += here;
      counts.Most = std::max(counts.Most, here);
    }
    return true;
  });
  counts.Lost = LeavesOf(shapes).size() - placed;
  return counts;
}

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
