// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Minimum degree orders of small graphs. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Orders the vertices of small graphs by the number of neighbors that each still has when it is eliminated, exactly,
/// the lowest number first among equals. Neighborhoods are sets of bits; memory and time of an elimination grow with the
/// number of vertices. Keeps its memory from graph to graph.
class MinimumDegree
{
public:
  /// Begins a graph of @p own vertices to be ordered, numbers 0 to own, and @p halo further ones, numbers from own on,
  /// that are eliminated later, elsewhere.
  void Begin(Index own, Index halo);
  /// Makes @p other a neighbor of @p vertex, one to be ordered; call it for both ends where both are.
  void Connect(Index vertex, Index other);
  /// Eliminates all vertices.
  /// @return them in their order; valid until the next Begin()
  const std::vector<Index>& Order();

private:
  /// Makes the neighbors of @p vertex neighbors of each other, without it.
  void Eliminate(Index vertex);

  Index Own = 0;
  Index Words = 0;
  std::vector<std::uint64_t> Bits; ///< [Own, Words], neighbors of each vertex
  std::vector<Index> Degrees;      ///< [Own]
  std::vector<Index> Result;
};

} // namespace surfsynth
