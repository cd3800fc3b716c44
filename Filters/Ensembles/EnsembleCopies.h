// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Members of an ensemble as moved copies of one dataset. Private to the module.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

class vtkMultiBlockDataSet;
class vtkPointSet;

namespace surfsynth
{

/// Options of FillWithCopies().
struct CopyOptions
{
  std::string DisplacementArrayName;
  int FirstSample = 0;
  double Spread = 0.0; ///< distance of neighbors in a grid in the xy plane, in boxes; 0 for all in one place
  BoundingBox Box;     ///< of the dataset
};

/// Adds arrays to the copy of sample @p k, which is counted from 0.
using CopyDecorator = std::function<void(vtkPointSet* copy, std::size_t k)>;

/// Fills @p output with a copy of @p input for each sample, named "Sample k": with its points, of the precision of the
/// input, with their displacement from @p rest [V, 3], and without normals. Frees @p samples one by one.
/// @throws Cancelled
void FillWithCopies(vtkMultiBlockDataSet* output, vtkPointSet* input, const PointMatrix& rest,
  std::vector<PointMatrix>& samples, const CopyOptions& options, const CopyDecorator& decorate,
  const Progress& progress);

} // namespace surfsynth
