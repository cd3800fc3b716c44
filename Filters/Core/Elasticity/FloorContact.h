// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Contact of nodes with the floor z = 0. Private to the library.
#pragma once

#include "Core/Elasticity/Barrier.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// A barrier holds the nodes of the boundary above the floor, and Coulomb's friction, smooth at small speeds and with the
/// pressures of the beginning of a time step [Li2020], holds them in place. Energies are in joules, positions in meters.
class FloorContact
{
public:
  /// @param areas of the boundary at each node
  /// @param friction coefficient of Coulomb's friction
  /// @param slip speed below which friction grows with the speed, meters per second
  FloorContact(const Barrier& barrier, Eigen::VectorXd areas, double friction, double slip);

  /// Begins a time step of @p step seconds at these positions.
  void Begin(const PointMatrix& points, double step);

  /// Energy of the barrier.
  double Energy(const PointMatrix& points) const;
  /// Energy whose derivative is the friction of this time step.
  double FrictionEnergy(const PointMatrix& points) const;
  /// Adds the derivative of both to @p gradient.
  void AddGradient(const PointMatrix& points, PointMatrix& gradient) const;
  /// Adds their second derivative, which is positive semi-definite.
  void AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const;
  /// Largest part of a move, at most 1, that leaves every node at least a tenth of its height.
  double LargestStep(const PointMatrix& points, const PointMatrix& move) const;

private:
  Eigen::Vector2d Slide(const PointMatrix& points, Index v) const
  {
    return (points.row(v) - this->Previous.row(v)).head<2>().transpose();
  }

  Barrier Floor;
  Eigen::VectorXd Areas;
  double Friction;
  double Slip;
  double SlipDistance = 0.0; ///< of this time step
  PointMatrix Previous;      ///< positions at its beginning
  Eigen::VectorXd Grip;      ///< largest friction of each node in it, newtons
};

} // namespace surfsynth
