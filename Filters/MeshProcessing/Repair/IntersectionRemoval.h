// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Removal of self-intersections from a halfedge mesh. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <cstdint>

namespace surfsynth
{

/// Result of RemoveIntersections().
struct IntersectionRemoval
{
  std::int64_t Before = 0;    ///< number of intersecting triangles before
  std::int64_t Left = 0;      ///< number of intersecting triangles after
  std::int64_t Fragments = 0; ///< number of small components removed that the removal had cut off
  double RefusedLoss = 0.0;   ///< fraction that a removal beyond the bound would have lost; 0 when there was none
};

/// Replaces intersecting triangles by patches that do not intersect, as far as possible, by CGAL's local removal. Keeps
/// the result with the fewest intersections among those with a LargestLoss() of at most @p maximumLoss, for which the
/// area of the intersecting triangles does not count; without one, @p mesh stays as it is. Property maps keep their values on triangles that stay; handles to them become invalid.
/// @param stop ends the work between two steps; may be null
/// @throws Cancelled
IntersectionRemoval RemoveIntersections(CgalMesh& mesh, double maximumLoss, const std::atomic<bool>* stop);

} // namespace surfsynth
