// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Distances on a surface along the edges of its triangles, and their mean length.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Lengths of the shortest paths of edges from each vertex to the nearest of @p sources, by Dijkstra's algorithm
/// [Dijkstra1959]. A distance is at least the geodesic one, and at most 2 / sqrt(3) times as long on equilateral
/// triangles in a plane. Needs no solver and takes any mesh with tables. O(V log V).
/// @param topology the tables of @p mesh
/// @param sources vertex ids; none gives infinity everywhere
/// @return [V] float64, world units, at least 0; 0 at the sources, infinity where no path leads.
/// @throws InvalidInput when a source is no vertex.
Eigen::VectorXd EdgeDistances(
  const TriangleMesh& mesh, const MeshTopology& topology, const std::vector<Index>& sources);

/// Mean length of the edges, each once, world units; not a number without edges.
/// @param topology the tables of @p mesh
double MeanEdgeLength(const TriangleMesh& mesh, const MeshTopology& topology);

} // namespace surfsynth
