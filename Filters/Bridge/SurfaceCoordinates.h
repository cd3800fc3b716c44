// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture coordinates of the points of VTK surfaces as those of triangle corners.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "SurfaceBridge.h"

#include "Core/Atlas/TextureCoordinates.h"

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// Reads the active texture coordinates of the points of @p polydata, from which @p surface was converted.
/// @return [3 F, 2]
/// @throws InvalidInput when there are none, or they have fewer than 2 components, not a tuple for each point, or are
/// not finite at a point of a triangle.
VTKSURFACESYNTHESISBRIDGE_EXPORT TextureCoordinates ReadTextureCoordinates(
  vtkPolyData* polydata, const Surface& surface);

/// Returns true when a coordinate lies outside [0, 1] by more than 1e-4: the texture is repeated.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool IsRepeated(const TextureCoordinates& coordinates, const Surface& surface);

/// Returns a warning about triangles without area in the texture; empty without such.
/// @param coordinates finite
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string DescribeDegenerateCoordinates(
  const TextureCoordinates& coordinates, const Surface& surface);

/// Checks that coordinates, which are finite, are those of an atlas.
/// @throws InvalidInput when some lie outside [0, 1] by more than 1e-4.
VTKSURFACESYNTHESISBRIDGE_EXPORT void RequireAtlas(const TextureCoordinates& coordinates, const Surface& surface);

} // namespace surfsynth
