// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Remeshing [Botsch2004] with a target edge length that varies over the surface. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <vector>

namespace surfsynth
{

/// Edges and vertices of a CgalMesh that remeshing must keep: edges of curves, whose points stay on them, and fixed
/// vertices.
struct RemeshingConstraints
{
  CgalMesh::Property_map<CgalEdge, bool> IsCurve;   ///< boundary edges are curves without being marked
  CgalMesh::Property_map<CgalVertex, bool> IsFixed; ///< vertices that stay
};

/// Remeshes @p mesh in place by rounds of splits, collapses, flips and relaxation. The target length of an edge is the
/// mean of those of its ends.
/// @param lengthOfVertex [V], target edge length at each vertex, interpolated linearly over the surface at the call
/// @param iterations number of rounds, at least 1
/// @param relaxationSteps number of steps of tangential relaxation in each round
/// @param stop ends the work between two rounds, without an error; may be null.
void RemeshAdaptively(CgalMesh& mesh, const RemeshingConstraints& constraints,
  const std::vector<double>& lengthOfVertex, int iterations, int relaxationSteps, const std::atomic<bool>* stop);

} // namespace surfsynth
