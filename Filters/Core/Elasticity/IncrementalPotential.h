// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Implicit Euler of an elastic body as a minimisation [Li2020]. Private to the library.
#pragma once

#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticSurroundings.h"
#include "Core/Elasticity/FloorContact.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Elasticity/SelfContact.h"
#include "Core/Mesh/TriangleMesh.h"

#include <optional>
#include <vector>

namespace surfsynth
{

/// Function of the positions x at the end of a time step of h seconds, joules,
///   |x - y|^2_M / (2 h^2) + c |x - x0|^2_M / (2 h) + V(x) + friction,    y = x0 + h v0,
/// whose minimum is the step of implicit Euler; V is the potential energy: elastic, of weight, loads, tethers and contact.
class IncrementalPotential
{
public:
  IncrementalPotential(const ElasticBody& body, const ElasticSurroundings& surroundings);

  /// Begins a time step at these positions and velocities.
  void Begin(const PointMatrix& points, const PointMatrix& velocities, double step);
  /// Prepares contact for moves up to @p move from @p points.
  void PrepareMove(const PointMatrix& points, const PointMatrix& move);

  /// The function.
  double Value(const PointMatrix& points) const;
  /// Its derivative, newtons, zero at fixed points.
  PointMatrix Gradient(const PointMatrix& points) const;
  /// Its second derivative, made positive definite; unit rows at fixed points. The pattern must hold Coupled().
  void FillStiffness(const PointMatrix& points, NodeMatrix& stiffness) const;
  /// Pairs of nodes that contact couples.
  std::vector<NodePair> Coupled(const PointMatrix& points) const;
  /// Largest part of a move, at most 1, in which nothing meets.
  double LargestStep(const PointMatrix& points, const PointMatrix& move) const;

  /// V, joules.
  double PotentialEnergy(const PointMatrix& points) const;
  /// Derivative of V and of friction, newtons: what accelerates the body, with its sign turned; zero at fixed points.
  PointMatrix Imbalance(const PointMatrix& points) const;

private:
  void ClearFixed(PointMatrix& rows) const;

  const ElasticBody& Body;
  const ElasticSurroundings& Surroundings;
  std::optional<FloorContact> Floor;
  std::optional<SelfContact> Self;
  double Step = 1.0;
  PointMatrix Start;   ///< x0
  PointMatrix Inertia; ///< y
};

} // namespace surfsynth
