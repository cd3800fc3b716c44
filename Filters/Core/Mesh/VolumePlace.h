// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places in a tetrahedral mesh: a tetrahedron and barycentric coordinates.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// A place in a tetrahedral mesh.
struct VolumePlace
{
  Index Tetrahedron = -1;                            ///< id of the tetrahedron; -1 for no place
  Eigen::Vector4d Weights = Eigen::Vector4d::Zero(); ///< barycentric coordinates, at least 0, sum 1
};

/// Finds the place in tetrahedron @p t of @p mesh, which has a volume, that is nearest to @p point.
VolumePlace NearestInTetrahedron(const TetrahedralMesh& mesh, Index t, const Eigen::Vector3d& point);

/// Returns the position of a place, world units.
Eigen::Vector3d PositionOf(const TetrahedralMesh& mesh, const VolumePlace& place);

} // namespace surfsynth
