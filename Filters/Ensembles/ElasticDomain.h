// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tetrahedra that stand for a surface or a volume in a simulation. Private to the module.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/VolumePlace.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Tetrahedra without points that none of them uses, world units, and points that move with them.
struct ElasticDomain
{
  TetrahedralMesh Mesh;
  PointMatrix Points;              ///< [V, 3], of the dataset
  std::vector<VolumePlace> Places; ///< [V], nearest to each point; no place where it is not finite and stays
  PointMatrix Offsets;             ///< [V, 3], of each point from its place: 0 inside the tetrahedra
  Eigen::VectorXd Weights;         ///< [V], area of a surface around each point, or volume

  /// Points of the dataset for these nodes: their places, and offsets that turn with the tetrahedra.
  PointMatrix Follow(const PointMatrix& nodes) const;
};

/// Checks the tetrahedra of a converted volume, and returns them without unused points.
/// @throws InvalidInput
TetrahedralMesh TetrahedraOf(const Surface& volume);

/// Makes the domain of a converted dataset: its own tetrahedra; or @p tetrahedra, where there are some; or tetrahedra that
/// fill the surface, which is checked, remeshed to @p surfacePoints points, or as it is for 0.
/// @throws InvalidInput, SolverFailure, Cancelled
ElasticDomain MakeElasticDomain(
  Surface& content, const TetrahedralMesh* tetrahedra, int surfacePoints, const Progress& progress);

} // namespace surfsynth
