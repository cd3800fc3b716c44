// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Forces and obstacles around an elastic body.
#pragma once

#include "Core/Elasticity/ElasticTethers.h"
#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// Weight, floor, contact, loads and tethers, in SI units. The floor is the plane z = 0.
struct ElasticSurroundings
{
  double Gravity = 9.81;         ///< meters per square second along -z
  bool HasFloor = true;          ///< the body stays above z = 0
  bool HasSelfContact = true;    ///< see SelfContact
  double ContactDistance = 2e-3; ///< at which contact begins, as a fraction of the diagonal of the box at rest
  double Friction = 0.5;         ///< coefficient of Coulomb's friction on the floor, at least 0
  double Damping = 0.5;          ///< loss of momentum by the air, per second, at least 0
  PointMatrix Loads;             ///< [V, 3] forces on the nodes, newtons; or empty
  std::vector<bool> IsFixed;     ///< [V], true for nodes that do not move; or empty
  ElasticTethers Tethers;        ///< springs to fixed ends
};

} // namespace surfsynth
