// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The levels of a texture as blocks.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <map>
#include <vector>

class vtkDataObject;
class vtkMultiBlockDataSet;

namespace surfsynth
{

/// The surfaces of all levels, coarse to fine, by the flat index of the block that they were grown on: 0 for a dataset
/// by itself.
using LevelSurfaces = std::map<unsigned int, std::vector<vtkSmartPointer<vtkPolyData>>>;

/// Fills @p output with a block for each level, named "Level 2" and so on from @p firstLevel: the surface of that
/// level, or where @p held, which has the structure of the input, is composite a tree of them. What has no surfaces
/// stays empty.
VTKSURFACESYNTHESISBRIDGE_EXPORT void ArrangeLevels(
  const LevelSurfaces& surfaces, vtkDataObject* held, int firstLevel, vtkMultiBlockDataSet* output);

} // namespace surfsynth
