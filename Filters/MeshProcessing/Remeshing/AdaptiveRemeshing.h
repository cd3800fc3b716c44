// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Remeshing with a target edge length that varies over the surface. Private to the meshing module.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <vector>

namespace surfsynth
{

/// The edges and vertices of a CgalMesh that remeshing must keep: edges of curves, whose points stay on them, and
/// vertices that stay.
struct RemeshingConstraints
{
  CgalMesh::Property_map<CgalEdge, bool> IsCurve; ///< boundary edges are curves without being marked
  CgalMesh::Property_map<CgalVertex, bool> IsFixed;
};

/// Remeshes @p mesh in place by @p iterations rounds of splits, collapses, flips and relaxation, towards the edge length
/// @p lengthOfVertex, which is interpolated linearly over the surface as it is at the call. An edge aims at the mean of
/// its ends.
/// @param stop ends the work between two rounds; may be null.
void RemeshAdaptively(CgalMesh& mesh, const RemeshingConstraints& constraints,
  const std::vector<double>& lengthOfVertex, int iterations, int relaxationSteps, const std::atomic<bool>* stop);

} // namespace surfsynth
