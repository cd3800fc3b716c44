// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Regular parts of triangulations, where field latents lose flat colors.
#pragma once

#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include "SurfaceBridge.h"

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Moves the vertices near the centroids of their rings, CentralVertices() with 0.05, which include those of regular parts,
/// along an edge each, by a random 0.1 to 0.25 of its length, then to the nearest place of the surface that
/// @p triangulation is one of; in rounds until none is left, at most three. A vertex
/// on a crease of more than 60 degrees moves along the crease; one where three or more creases meet stays. All other
/// vertices keep their bits. Deterministic.
/// @param surface mesh that places lie on
/// @param places [V], of the points of @p triangulation on @p surface, which move with them
/// @throws InvalidInput as WeldedSurface of @p triangulation.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT void MoveRegularVertices(
  const TriangleMesh& surface, Surface& triangulation, std::vector<SurfacePlace>& places);

/// Describes the number of vertices in regular parts; "" for 0. @param remedy what to do, to the end of the sentence
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT std::string DescribeRegularVertices(
  std::int64_t regular, std::int64_t vertices, const std::string& remedy);

} // namespace surfsynth
