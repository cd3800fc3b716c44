// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Subdivision that cuts each triangle into four at the midpoints of its edges.
#pragma once

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// A subdivided mesh, and the edges that its new vertices lie on.
struct SubdividedMesh
{
  /// Vertices [V + E]: the old ones, then the midpoints in order of first appearance when triangles are scanned f = 0
  /// ... F - 1 and their edges (v0 v1), (v1 v2), (v2 v0). Triangles [4 F] in blocks of F: [v0, m0, m2], then [v1, m1,
  /// m0], then [v2, m2, m1], then [m0, m1, m2], m_i being the midpoint of edge i: the order of [Hertz2020]. Triangle
  /// f + k F comes from triangle f.
  TriangleMesh Mesh;
  std::vector<std::array<Index, 2>> Parents; ///< [E], the ends of the edge that vertex V + e lies on
};

/// Cuts each triangle of any mesh, with or without boundary, into four; an edge has one midpoint however many triangles
/// share it. O(V + F) but for the sorting of the edges around each vertex.
/// @throws InvalidInput when an id is out of range, a triangle uses a vertex twice, or the result would have 2^31
/// vertices or triangles, or more.
SubdividedMesh SubdivideAtMidpoints(const TriangleMesh& mesh);

/// Interpolates rows at the points of a mesh, a matrix or a column, linearly to those of its subdivision, in parallel; none stay none.
/// @param parents SubdividedMesh::Parents
template <typename Rows>
Rows InterpolateAtMidpoints(Rows rows, const std::vector<std::array<Index, 2>>& parents)
{
  const Eigen::Index coarse = rows.rows();
  rows.conservativeResize(coarse > 0 ? coarse + static_cast<Eigen::Index>(parents.size()) : 0, rows.cols());
  ParallelFor(rows.rows() - coarse, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e)
    {
      const std::array<Index, 2>& ends = parents[static_cast<std::size_t>(e)];
      rows.row(coarse + e) = (rows.row(ends[0]) + rows.row(ends[1])) / 2;
    }
  });
  return rows;
}

} // namespace surfsynth
