// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces without the seams of their texture coordinates.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Tangent/OneRings.h"

#include <vector>

namespace surfsynth
{

/// A surface whose points at bit-equal coordinates are one vertex: the one with the lowest id of those that triangles
/// use. Ids of points and triangles stay.
struct WeldedSurface
{
  /// Welds and checks @p surface, and unfolds its rings.
  /// @throws InvalidInput when the welded surface is not manifold or not consistently wound; see CheckMesh().
  explicit WeldedSurface(const Surface& surface);

  std::vector<Index> VertexOfPoint; ///< [V], of the points that no triangle uses themselves
  TriangleMesh Mesh;                ///< all points, and the triangles between vertices
  OneRings Rings;                   ///< rings of the vertices; those of all other points are empty

  /// True for a point that is a vertex of triangles.
  bool IsVertex(Index point) const { return this->Rings.RingStart[point] < this->Rings.RingStart[point + 1]; }
};

} // namespace surfsynth
