// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Reduction of displacements until no triangles of a displaced mesh intersect.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <atomic>
#include <cstdint>

namespace surfsynth
{

/// Result of ReduceDisplacement().
struct ReducedDisplacement
{
  PointMatrix Displacement;             ///< [V, 3], world units
  std::int64_t NumberOfPairsBefore = 0; ///< number of intersecting pairs with the full displacement
  std::int64_t NumberOfPairsLeft = 0;   ///< number of intersecting pairs, all of them of triangles that do not move
  double Height = 0.0;                  ///< integral of the absolute displacement along the normals of the base
  double HeightBefore = 0.0;            ///< the same with the full displacement
  int NumberOfRounds = 0;               ///< number of reductions
};

/// Reduces the displacements of a mesh around the pairs of triangles that intersect, until none is left.
///
/// Point v lies at b + t T + n N, where T and N are the tangential and the normal part of its displacement, by the normals of
/// the base, and t and n begin at 1. In each round t falls to 3/4 at the corners of intersecting triangles, and n where t has
/// reached 0: a displacement along normals alone, a height field, intersects only where the base is curved more than the
/// texture is high, so that little height is lost. Factors below 0.02 become 0. Towards 1 the reduction fades over about
/// twice the largest displacement there, in rings of edges, as a cosine. Pairs are those of FindIntersectingPairs(), of the
/// points rounded to single precision, in which meshes are written for slicers, and as they are. Pairs whose corners
/// have no displacement left are those of the base, and stay. Points without a displacement keep their place to the
/// last bit.
///
/// Deterministic. A round costs the search for pairs with moved triangles.
/// @param base the mesh without displacement, valid: finite points, ids in range, proper triangles
/// @param displacement [V, 3], finite, world units
/// @param stop ends the work with Cancelled; may be null
/// @throws Cancelled
ReducedDisplacement ReduceDisplacement(
  const TriangleMesh& base, const PointMatrix& displacement, const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
