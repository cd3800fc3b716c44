// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places on a triangle mesh.
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
  Index Triangle = -1;
  Eigen::Vector3d Weights = Eigen::Vector3d::Zero(); ///< barycentric coordinates, at least 0, sum 1
};

/// The place of the point of triangle @p f of @p mesh that is nearest to @p point.
SurfacePlace NearestOnTriangle(const TriangleMesh& mesh, Index f, const Eigen::Vector3d& point);

/// Search structure that a caller lends: returns the nearest place of @p mesh, which has at least one triangle and finite
/// points, to each row of @p points [N, 3]. FindNearestPlaces() of the bridge is one, by VTK's cell locator.
using PlaceFinder = std::function<std::vector<SurfacePlace>(const TriangleMesh& mesh, const PointMatrix& points)>;

} // namespace surfsynth
