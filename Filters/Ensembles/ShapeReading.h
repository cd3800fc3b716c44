// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Moved copies of a body, as an input. Private to the module.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstddef>
#include <string>
#include <vector>

class vtkDataObject;
class vtkPointSet;

namespace surfsynth
{

/// A moved copy of a body.
struct MovedCopy
{
  vtkPointSet* Copy = nullptr; ///< belongs to the input
  std::string Name;            ///< "Block 3", or "The dataset" by itself: begins messages
};

/// Finds the place of a block of @p input in @p shapes: @p shapes itself for flat index 0, and null where the place is
/// missing or empty. A composite dataset in the place of a block counts as one.
vtkDataObject* ShapesOfBlock(vtkDataObject* input, vtkDataObject* shapes, unsigned int flatIndex);

/// Numbers of shapes.
struct ShapeCounts
{
  std::size_t Most = 0; ///< of the block that has the most of them
  std::size_t Lost = 0; ///< in no place of a block, 0 for a dataset by itself
};

/// Counts the shapes of the blocks of @p input.
ShapeCounts CountShapes(vtkDataObject* input, vtkDataObject* shapes);

/// The datasets of @p shapes, a dataset or the leaves of a composite one, in order, without null ones.
/// @throws InvalidInput when there is none, or one has no points of its own or another number of points than @p body
std::vector<MovedCopy> MovedCopies(vtkDataObject* shapes, vtkPointSet* body);

/// Points [V, 3] of a copy, world units; those that are not finite in @p rest [V, 3] are as there.
/// @throws InvalidInput for coordinates that are not finite
PointMatrix PointsOfCopy(const MovedCopy& shape, const PointMatrix& rest);

} // namespace surfsynth
