// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Place and turn of a rest state about the vertical. Private to the library.
#pragma once

#include "Core/Elasticity/ElasticBody.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Center of mass of the body at these positions [V, 3].
Eigen::RowVector3d CenterOfMass(const ElasticBody& body, const PointMatrix& points);

/// Turns @p points about z so that the long axis of their plan is that of the body's, and centers them on it.
/// @param towards of the two turns that do so the one that brings the points nearer to these, [V, 3]
void AlignPlan(const ElasticBody& body, PointMatrix& points, const PointMatrix& towards);

} // namespace surfsynth
