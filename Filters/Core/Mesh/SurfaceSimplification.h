// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Simplification of a surface to a coarse one of the same topology, and the map of its places back.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <memory>
#include <vector>

namespace surfsynth
{

/// Coarse surface of the topology of a finer one, and the bijective map between both: successive self-parameterization by
/// half-edge collapses [Lee1998] [Liu2020].
///
/// Each step removes the vertex of least cost: the length of an edge plus three times the distance of the vertex from the
/// triangles that result, over the shape of the worst of those, so that triangles stay even and tips stay. The triangles around
/// it are laid out in the plane, with the angles scaled to a full turn, on a boundary to half a turn; the vertex goes to an end
/// of an edge where no triangle of the plane turns over. An edge collapses only where the topology stays (link condition).
/// Vertices of a boundary move along that boundary only, so that boundaries map onto boundaries. Deterministic. O(V log V).
class SurfaceSimplification
{
public:
  /// Simplifies @p mesh until it has at most @p triangles, or no vertex can go any more.
  /// @param mesh manifold edges and vertices, consistent winding, no point without triangle
  /// @throws InvalidInput when the mesh is not so; Cancelled
  SurfaceSimplification(const TriangleMesh& mesh, Index triangles, const Progress& progress = {});
  ~SurfaceSimplification();
  SurfaceSimplification(const SurfaceSimplification&) = delete;
  SurfaceSimplification& operator=(const SurfaceSimplification&) = delete;

  /// The coarse surface.
  const TriangleMesh& Coarse() const;

  /// Ids of the points of the coarse surface on the finer one, ascending.
  const std::vector<Index>& PointsOnInput() const;

  /// Returns the places of the finer surface that places of the coarse one map to, in the same order.
  /// @throws InvalidInput when a place names a triangle that the coarse surface does not have
  std::vector<SurfacePlace> OnInput(const std::vector<SurfacePlace>& places) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
