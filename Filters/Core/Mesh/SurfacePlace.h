// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places on a triangle mesh: a triangle and barycentric coordinates.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace surfsynth
{

/// A place on a triangle mesh.
struct SurfacePlace
{
  Index Triangle = -1;                               ///< id of the triangle; -1 for no place
  Eigen::Vector3d Weights = Eigen::Vector3d::Zero(); ///< barycentric coordinates, at least 0, sum 1
};

/// Returns the position of a place.
Eigen::Vector3d PositionOf(const TriangleMesh& mesh, const SurfacePlace& place);

/// Finds the place in triangle @p f of @p mesh that is nearest to @p point.
SurfacePlace NearestOnTriangle(const TriangleMesh& mesh, Index f, const Eigen::Vector3d& point);

/// Search function of the caller: returns the place of @p mesh nearest to each row of @p points [N, 3]. The mesh has at
/// least one triangle, and finite points. FindNearestPlaces() of the bridge is one, by VTK's cell locator.
using PlaceFinder = std::function<std::vector<SurfacePlace>(const TriangleMesh& mesh, const PointMatrix& points)>;

} // namespace surfsynth
