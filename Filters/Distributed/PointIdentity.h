// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Identity of the points of a mesh that lies in pieces on several ranks. Private to the library.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Distributed/RankGroup.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The points of a piece as points of the whole.
struct PointIdentity
{
  std::vector<std::int64_t> WholeIds;   ///< [V], id in the whole
  std::vector<bool> Shared;             ///< [V], true for points that other points of the pieces are, too
  PointMatrix Points;                   ///< [V, 3], coordinates in the piece of the lowest rank that holds the point
  std::int64_t NumberOfWholePoints = 0; ///< of all pieces together
};

/// Finds which points of the pieces are the same, and numbers the points of the whole: by their global ids, in the order of
/// these, where all pieces with points have them; else by coordinates that pieces of different ranks share, in the order of
/// ranks. Points with NaN are shared with none. Each rank holds its own points and as many for others. Collective.
/// @param points [V, 3] of the piece
/// @param globalIds [V], or empty for none
PointIdentity IdentifyPoints(
  const RankGroup& ranks, const PointMatrix& points, const std::vector<std::int64_t>& globalIds);

} // namespace surfsynth
