// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rest states next to given shapes of an elastic body, such as those of a generative model.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticMotion.h"
#include "Core/Elasticity/ElasticSurroundings.h"
#include "Core/Mesh/VolumePlace.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Options of settling, in SI units.
struct SettlingOptions
{
  ElasticMaterial Material;         ///< of the whole body
  ElasticSurroundings Surroundings; ///< without loads, tethers and damping
  MotionOptions Motion;             ///< without MaximumTime: the body creeps
  bool Align = true;                ///< see DropOptions; of the two turns the smaller one
};

/// A body that is brought into given shapes and let go. It is laid, undeformed, next to a shape and drawn into it by
/// springs, which stop where the floor, the body itself or turned tetrahedra are in the way; without them it creeps to the
/// next equilibrium. The z axis points upwards, the floor is z = 0.
class ElasticSettling
{
public:
  /// @param mesh see ElasticBody; meters
  /// @param places [K] in the mesh, of the points of the shapes; those without a tetrahedron do not matter
  /// @param offsets [K, 3] of these points from their places in the body at rest, meters
  /// @param weights [K] of the points, at least 0: the area or volume around each
  /// @throws InvalidInput
  ElasticSettling(TetrahedralMesh mesh, std::vector<VolumePlace> places, PointMatrix offsets, Eigen::VectorXd weights,
    const SettlingOptions& options);

  /// Rest state next to a shape, [K, 3] meters, finite where points have a place and a weight, of any height above the floor.
  /// Uses one thread.
  /// @throws SolverFailure for shapes that are too far from those of the body, such as a thousand times its size; Cancelled
  ElasticEquilibrium Settle(const PointMatrix& shape, const Progress& progress = {}) const;

  /// Rest states next to shapes, in parallel.
  /// @param first index of the first one, for messages
  /// @throws SolverFailure, which names the sample; Cancelled
  std::vector<ElasticEquilibrium> Settle(
    const std::vector<PointMatrix>& shapes, int first, const Progress& progress = {}) const;

private:
  ElasticEquilibrium SettleBound(const PointMatrix& shape, const Progress& progress) const;

  SettlingOptions Options;
  ElasticBody Elastic;
  std::vector<VolumePlace> Places;
  PointMatrix Rest;    ///< [K, 3] positions of the places
  PointMatrix Offsets; ///< [K, 3]
  Eigen::VectorXd Weights;
};

} // namespace surfsynth
