// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Repair of triangles that do not make a manifold yet. Private to the meshing module.
#pragma once

#include "MeshProcessing/Repair/SurfaceRepair.h"

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// Triangles on their way to a manifold.
struct Soup
{
  TriangleMesh Mesh;
  std::vector<Index> OriginOfTriangle; ///< the triangle of the first mesh that each one comes from
};

/// Makes points within @p tolerance of each other (0: of equal coordinates) one, and drops triangles that thereby lose a
/// corner. @return number of points that went into another
std::int64_t MergePoints(Soup& soup, double tolerance);

/// Keeps one of all triangles on the same three points. @return number of triangles dropped
std::int64_t RemoveDuplicateTriangles(Soup& soup);

/// What MakeManifold() did.
struct ManifoldChanges
{
  std::int64_t FlippedTriangles = 0;
  std::int64_t AddedPoints = 0; ///< copies of points on which sheets met
};

/// Winds neighbours alike and takes sheets that meet in an edge or a point apart. Each connected part keeps the winding
/// that most of its triangles, by area, had.
ManifoldChanges MakeManifold(Soup& soup);

} // namespace surfsynth
