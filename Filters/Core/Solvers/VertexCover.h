// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Smallest vertex covers of bipartite graphs. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <utility>
#include <vector>

namespace surfsynth
{

/// Vertices of a cover.
struct VertexCover
{
  std::vector<bool> Left;  ///< [L], whether a vertex of the left side is in it
  std::vector<bool> Right; ///< [R], the same of the right side
};

/// Returns a smallest set of vertices that touches every edge, from a largest matching (Koenig's theorem).
/// @param left, right Number of vertices of each side, L and R.
/// @param edges Pairs of a left and a right vertex; sorted by the function.
VertexCover MinimumVertexCover(Index left, Index right, std::vector<std::pair<Index, Index>>& edges);

} // namespace surfsynth
