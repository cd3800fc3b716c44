// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Peaks of a height function on a triangle mesh, their topological prominence and the regions around them.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Peaks of a height function.
struct HeightPeaks
{
  std::vector<Index> Peaks;    ///< [N], vertices of the peaks, ascending
  Eigen::VectorXd Prominences; ///< [V], prominence of each peak, 0 at all other vertices, units of the heights
  /// [V], number in Peaks of the peak that a vertex belongs to, -1 for vertices that no triangle uses and in components
  /// without a peak.
  std::vector<Index> Regions;
  /// [N], height of the highest saddle between a peak and a neighboring one; minus infinity without a neighbor.
  Eigen::VectorXd Saddles;
  /// [N], highest value of (saddle - base) / (lower of both peaks - base) over the neighbors of a peak; 0 without a neighbor.
  Eigen::VectorXd SaddleRatios;
};

/// Finds the local maxima of the heights whose prominence is larger than a minimum.
///
/// The prominence of a maximum is its persistence in the filtration by superlevel sets [Edelsbrunner2002]: vertices are added
/// in descending order of height, those of equal height by ascending id, and where two components of what was added meet, the
/// one with the lower maximum ends; its prominence is the height of its maximum over the place where they meet. That of the
/// highest maximum of a connected component of the mesh is its height over the lowest vertex of the component.
///
/// A vertex belongs to the peak that the steepest edges upwards lead to (largest height, then lowest id, of the neighbors);
/// maxima that are no peaks hand their vertices to the region on the other side of the saddle at which they end. The saddle
/// of two regions that share an edge is the largest lower height of the ends of their common edges. Peaks of one height and
/// the like depend on ids only in which of them is called the higher one.
///
/// O(V log V).
/// @param topology the tables of the mesh
/// @param heights [V], finite
/// @param minimumProminence at least 0, units of the heights
/// @param base height that the ratios of saddles count from
HeightPeaks FindHeightPeaks(
  const MeshTopology& topology, const Eigen::VectorXd& heights, double minimumProminence, double base);

} // namespace surfsynth
