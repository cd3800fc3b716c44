// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Adjacency of triangles across their edges, and what is found by it: orientable patches and boundary loops.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Table of the triangle across each side of each triangle. Built in O(F), in parallel.
class TriangleAdjacency
{
public:
  static constexpr Index Boundary = -1; ///< the edge has no second triangle
  static constexpr Index Several = -2;  ///< the edge has more than one other triangle

  /// Builds the table.
  /// @param topology the tables of @p mesh
  TriangleAdjacency(const TriangleMesh& mesh, const MeshTopology& topology);

  /// Triangle across side @p side of triangle @p f, or Boundary or Several. A side runs from the corner of its number
  /// to corner (side + 1) % 3.
  Index Across(Index f, int side) const { return this->Beyond[3 * static_cast<std::size_t>(f) + side]; }

private:
  std::vector<Index> Beyond;
};

/// Patches of a surface: triangles that are connected by edges with two triangles.
struct SurfacePatches
{
  Index Count = 0;               ///< number of patches
  std::vector<Index> OfTriangle; ///< [F], patch of each triangle; patches are in order of their lowest triangle
  /// [F], 1 for a triangle wound like the first one of its patch, -1 for one wound the other way.
  std::vector<std::int8_t> Sign;
  std::vector<bool> Orientable; ///< [Count], false for a patch like a Moebius strip, whose signs mean nothing
};
/// Finds the patches of a mesh.
/// @param adjacency the table of @p mesh
SurfacePatches FindPatches(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

/// A closed walk along boundary edges.
struct BoundaryLoop
{
  Index FirstPoint = 0;   ///< one of its points
  std::int64_t Edges = 0; ///< number of edges
  double Length = 0.0;    ///< world units
};

/// Finds the boundary loops of a mesh, in order of their first triangle. Fans of triangles that meet in a point have
/// one boundary each. A walk that ends at an edge with three or more triangles counts as a loop too.
std::vector<BoundaryLoop> FindBoundaryLoops(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

} // namespace surfsynth
