// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Motion of an elastic body to its equilibrium.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticSurroundings.h"

#include <memory>

namespace surfsynth
{

/// Options of the time steps.
struct MotionOptions
{
  double TimeStep = 0.04;    ///< largest time step, seconds
  double MaximumTime = 10.0; ///< after it velocities are dropped, and the body creeps to its equilibrium; seconds
  double RestEnergy = 1e-5;  ///< largest kinetic energy at rest, as a fraction of weight times diagonal
  double RestTime = 0.2;     ///< time for which it must stay below, seconds
  double Imbalance = 5e-4;   ///< largest norm of the forces left on the nodes, as a fraction of weight and loads
  int MaximumSteps = 4000;   ///< largest number of time steps
  bool MustBalance =
    true; ///< false: ends without an error where it has come to after MaximumSteps, or where steps fail
};

/// End of a motion.
struct ElasticEquilibrium
{
  PointMatrix Points;               ///< [V, 3], meters
  double Time = 0.0;                ///< simulated time until velocities were dropped, seconds
  bool HasSettled = false;          ///< true: before MaximumTime
  double Imbalance = 0.0;           ///< norm of the forces left on the nodes, as a fraction of weight and loads
  double SmallestVolumeRatio = 0.0; ///< smallest volume of a tetrahedron over that at rest
  double LargestEnergyRise = 0.0; ///< largest rise of the energy in a time step, as a fraction of weight times diagonal
  int NumberOfTimeSteps = 0;
  int NumberOfIterations = 0; ///< of Newton's method
};

/// Implicit Euler by Newton's method with projected stiffness and a line search that keeps all tetrahedra from turning over
/// and contact apart [Li2020]. While the body moves, Newton's method ends after eight iterations. A step in which kinetic
/// and potential energy together rise is done again with half of its length, so that energy never rises. When the body
/// rests, velocities are dropped and time steps grow until the forces are in balance.
class ElasticMotion
{
public:
  /// Keeps references.
  ElasticMotion(const ElasticBody& body, const ElasticSurroundings& surroundings, const MotionOptions& options);
  ~ElasticMotion();

  /// Moves the body from these positions, above the floor, and velocities, [V, 3], meters and meters per second.
  /// @throws InvalidInput when the energy there is not finite; SolverFailure when it must be in balance and is not after
  /// MaximumSteps; Cancelled.
  ElasticEquilibrium Settle(PointMatrix points, PointMatrix velocities, const Progress& progress = {});

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
