// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Point arrays that guide the sampling of latents: labels, directions, masks.
#pragma once

#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include "LatentTriangulation.h"
#include "SurfaceBridge.h"

#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// Surface with arrays, and the triangulation whose vertices take their values.
struct GuidedSurface
{
  vtkPolyData* Arrays = nullptr;                      ///< has the point arrays
  const Surface* Converted = nullptr;                 ///< the same, converted
  const LatentTriangulation* Triangulation = nullptr; ///< of that surface
};

/// Reads labels: whole numbers from -1 (none) to @p numberOfLabels - 1, 1 component. A vertex has that of the nearest
/// corner of its triangle.
/// @throws InvalidInput naming the array and the property LabelArrayName.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT std::vector<std::int32_t> ReadLabels(
  const GuidedSurface& surface, const std::string& name, std::int64_t numberOfLabels);

/// Reads directions: vectors of 3 components, interpolated linearly. Their parts in the tangent planes are taken to unit
/// length; those below 1e-6 of the longest become 0, which guides nothing.
/// @return [V, 2], in the frames of the triangulation.
/// @throws InvalidInput naming the array and the property DirectionArrayName.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT FieldLatentMatrix ReadDirections(
  const GuidedSurface& surface, const std::string& name);

/// Reads a mask: numbers from 0 to 1, 1 component, interpolated linearly.
/// @throws InvalidInput naming the array and the property MaskArrayName.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT std::vector<float> ReadMask(
  const GuidedSurface& surface, const std::string& name);

} // namespace surfsynth
