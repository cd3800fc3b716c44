// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Features of vertices and the rings of vertices around them: heights and distances in the frame of a neighborhood.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Number of features of each ring.
constexpr int FeaturesOfRing = 6;
/// Largest number of rings that ComputeRingFeatures() takes.
constexpr int MaximumRings = 16;

/// [N, 6 R] float32, ring-major: for each ring the minimum, the quartiles and the maximum of the heights of its vertices,
/// then their mean tangential distance.
using RingFeatureMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Computes the features of the rings 1 to R around each vertex, in the units of the points.
///
/// Ring j of vertex v holds the vertices that j edges, and no fewer, join to v. The normal n of the neighborhood is the
/// unit vector along the sum of the area vectors of its vertices, those of the rings 0 to R; the area vector of a vertex is
/// the sum over its triangles of half of (b - a) x (c - a). Vertex w has the height h = (w - v) . n and the tangential
/// distance |(w - v) - h n|. Quartiles of m heights in ascending order lie at (m - 1) / 4, (m - 1) / 2 and 3 (m - 1) / 4,
/// between two heights by linear interpolation. Sets of vertices have no first one: features do not depend on the order of
/// vertices, triangles and corners, up to rounding, and turn and move with the mesh.
///
/// Only vertices whose rings are whole have a row: those that no triangle uses have none, and neither have those with a
/// boundary edge R - 1 edges or less away, unless all have. A ring without vertices, in a component that is too small,
/// has the features of the ring before it. The normal of area vectors that sum to 0 is 0.
///
/// O(V R^2) time on even meshes, O(V) memory beside the result and for each thread; the same bits for every number of
/// threads.
/// @param topology the tables of @p mesh
/// @param rings R, from 1 to MaximumRings
/// @return [N, 6 R], by ascending vertex
/// @throws Cancelled
RingFeatureMatrix ComputeRingFeatures(
  const TriangleMesh& mesh, const MeshTopology& topology, int rings, const Progress& progress = {});

} // namespace surfsynth
