// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Moved copies of a body, as an input. Private to the module.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

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

/// The datasets of @p shapes, a dataset or the leaves of a composite one, in order; null and empty ones are left out.
/// @throws InvalidInput when one has no points of its own, or there is none
std::vector<MovedCopy> MovedCopies(vtkDataObject* shapes);

/// Points [V, 3] of a copy of @p body, world units; those that are not finite in @p rest [V, 3] are as there.
/// @throws InvalidInput for another number of points, and for coordinates that are not finite
PointMatrix PointsOfCopy(const MovedCopy& shape, vtkPointSet* body, const PointMatrix& rest);

} // namespace surfsynth
