// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Distances on a surface along the edges of its triangles.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// [V] float64, world units: the length of the shortest path of edges from each vertex to the nearest of @p sources; 0
/// at these, infinity where no path leads. At least the geodesic distance, and 2 / sqrt(3) times as much at most on
/// equilateral triangles in a plane. Needs no solver and takes any mesh that has tables. O(V log V).
/// @param topology the tables of @p mesh
/// @throws InvalidInput when a source is no vertex.
Eigen::VectorXd EdgeDistances(
  const TriangleMesh& mesh, const MeshTopology& topology, const std::vector<Index>& sources);

} // namespace surfsynth
