// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random drops of an elastic body onto a floor, to where it rests: appendix C.2 of [Kuai2026].
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticMotion.h"
#include "Core/Elasticity/ElasticSurroundings.h"
#include "Core/Random/CounterNormals.h"

#include <vector>

namespace surfsynth
{

/// Options of the drops, in SI units.
struct DropOptions
{
  ElasticMaterial Material;         ///< of the whole body
  ElasticSurroundings Surroundings; ///< without loads
  MotionOptions Motion;
  double DropHeight = 0.1; ///< height of the lowest point above the floor at the beginning, meters, at least 0
  double MinimumSpin = 3.14159265358979; ///< least angular speed at the beginning, radians per second, at least 0
  double MaximumSpin = 9.42477796076938; ///< largest one
  bool RandomOrientation = true;         ///< any orientation at the beginning is as likely as any other
  bool Align =
    true; ///< turn rest states about z, so that the long axis of their plan is that of the body's, and center them
};

/// A body that is dropped many times. The z axis points upwards, the floor is z = 0.
class ElasticDrops
{
public:
  /// @param mesh see ElasticBody; meters
  /// @throws InvalidInput
  ElasticDrops(TetrahedralMesh mesh, const DropOptions& options);

  /// The body as it was given; only tetrahedra are turned round.
  const ElasticBody& Body() const { return this->Elastic; }

  /// Rest state of a drop. Orientation, axis and speed of the spin depend on seed, sample and stream of @p key only; the
  /// angular speed is uniform between the two bounds. Uses one thread.
  /// @throws SolverFailure, see ElasticMotion; Cancelled
  ElasticEquilibrium Drop(const NormalKey& key, const Progress& progress = {}) const;

  /// Rest states of samples @p first, @p first + 1, ..., in parallel.
  /// @throws SolverFailure, which names the sample; Cancelled
  std::vector<ElasticEquilibrium> Sample(const NormalKey& key, int count, const Progress& progress = {}) const;

private:
  DropOptions Options;
  ElasticBody Elastic;
};

} // namespace surfsynth
