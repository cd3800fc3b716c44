// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Search for self-intersections in any triangle mesh.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <atomic>
#include <vector>

namespace surfsynth
{

/// Finds the triangles that intersect another one in more than the points and edges that both share, with exact
/// predicates. Points of equal coordinates count as one point. Triangles that repeat a point, have no area or a NaN or
/// infinite coordinate are left out; so are pairs with the same three points (duplicate triangles). O(F log F + pairs
/// of triangles whose boxes overlap).
/// @param mesh ids in range
/// @param stop ends the search with Cancelled; may be null
/// @return ids, ascending
/// @throws Cancelled
std::vector<Index> FindIntersectingTriangles(const TriangleMesh& mesh, const std::atomic<bool>* stop = nullptr);

/// Finds the pairs of triangles that intersect in more than the points and edges that both share, by the same rules.
/// @return ids of both triangles, the lower one first; ascending
/// @throws Cancelled
std::vector<std::array<Index, 2>> FindIntersectingPairs(
  const TriangleMesh& mesh, const std::atomic<bool>* stop = nullptr);

/// Finds those of these pairs that have a triangle of @p subset.
/// @param subset ids, each once
/// @return ids of both triangles, the lower one first; ascending
/// @throws Cancelled
std::vector<std::array<Index, 2>> FindIntersectingPairsOf(
  const TriangleMesh& mesh, const std::vector<Index>& subset, const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
