// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Which triangles lie beside each other, and what follows from walking over their edges: orientation, boundary loops.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// For each side of each triangle, the triangle beyond it. O(F), in parallel.
class TriangleAdjacency
{
public:
  static constexpr Index Boundary = -1; ///< the edge has no second triangle
  static constexpr Index Several = -2;  ///< the edge has more than one other triangle

  /// @param topology the tables of @p mesh
  TriangleAdjacency(const TriangleMesh& mesh, const MeshTopology& topology);

  /// The triangle beyond side @p side of triangle @p f, which runs from its corner side to corner (side + 1) % 3; or
  /// Boundary or Several.
  Index Across(Index f, int side) const { return this->Beyond[3 * static_cast<std::size_t>(f) + side]; }

private:
  std::vector<Index> Beyond;
};

/// The parts of a surface that hang together by edges with two triangles, and whether each can be oriented.
struct SurfacePatches
{
  Index Count = 0;
  std::vector<Index> OfTriangle; ///< [F], in order of their lowest triangle
  /// [F], 1 for a triangle wound like the first one of its patch, -1 for one wound the other way.
  std::vector<std::int8_t> Sign;
  std::vector<bool> Orientable; ///< [Count], false for a patch like a Moebius strip, whose signs mean nothing
};
SurfacePatches FindPatches(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

/// A closed walk along boundary edges.
struct BoundaryLoop
{
  Index FirstPoint = 0;   ///< one of its points
  std::int64_t Edges = 0; ///< how many
  double Length = 0.0;    ///< world units
};

/// The boundary loops of a mesh, in order of their first triangle. Where several fans of triangles meet in a point, each
/// has a boundary of its own. A walk that ends at an edge with three or more triangles counts as a loop too.
std::vector<BoundaryLoop> FindBoundaryLoops(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

} // namespace surfsynth
