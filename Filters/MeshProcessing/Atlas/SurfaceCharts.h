// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Charts: connected sets of triangles as meshes of their own. Private to the mesh processing.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleAdjacency.h"
#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// A connected set of triangles.
struct SurfaceChart
{
  std::vector<Index> Triangles; ///< ids in the whole mesh, ascending
  /// The triangles in their order, with points of their own; a point at which the chart only touches itself is one for
  /// each fan.
  TriangleMesh Mesh;
  bool IsDisk = false; ///< has one boundary and no handle
};

/// Cuts charts out of a mesh.
class ChartCutter
{
public:
  /// Prepares the tables of @p mesh, which is manifold and consistently wound, and outlives the object.
  explicit ChartCutter(const TriangleMesh& mesh, const MeshTopology& topology);

  /// Returns the parts of @p triangles that are connected across edges and have the same label, in order of their lowest
  /// triangle.
  /// @param labels one for each of @p triangles; empty when all are the same
  std::vector<std::vector<Index>> ConnectedParts(
    const std::vector<Index>& triangles, const std::vector<std::size_t>& labels = {});

  /// Cuts out a connected set of triangles.
  SurfaceChart Cut(const std::vector<Index>& triangles);

private:
  const TriangleMesh& Mesh;
  TriangleAdjacency Adjacency;
  std::vector<Index> Place; ///< [F], place of each triangle in the set at work; -1 outside
};

} // namespace surfsynth
