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

/// Number of shapes of the block of @p input that has the most of them; of a dataset by itself all.
std::size_t MostShapes(vtkDataObject* input, vtkDataObject* shapes);

/// The datasets of @p shapes, a dataset or the leaves of a composite one, in order, without null ones.
/// @throws InvalidInput when there is none, or one has no points of its own or another number of points than @p body
std::vector<MovedCopy> MovedCopies(vtkDataObject* shapes, vtkPointSet* body);

/// Points [V, 3] of a copy, world units; those that are not finite in @p rest [V, 3] are as there.
/// @throws InvalidInput for coordinates that are not finite
PointMatrix PointsOfCopy(const MovedCopy& shape, const PointMatrix& rest);

} // namespace surfsynth
