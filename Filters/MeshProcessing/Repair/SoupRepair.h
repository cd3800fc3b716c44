// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Repair of triangle soups. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Repair/SurfaceRepair.h"

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// A triangle soup: a mesh that need not be manifold.
struct Soup
{
  TriangleMesh Mesh;                   ///< points and triangles
  std::vector<Index> OriginOfTriangle; ///< [F], triangle of the first mesh that each one comes from
};

/// Lowest of the points of the same coordinates, for each point; points that are not finite stand for themselves.
std::vector<Index> EqualPoints(const PointMatrix& points);

/// Merges points within @p tolerance of each other (0: of equal coordinates), and removes triangles that lose a corner.
/// @param tolerance world units, at least 0
/// @return number of points that were merged into another
std::int64_t MergePoints(Soup& soup, double tolerance);

/// Keeps one of all triangles on the same three points.
/// @return number of triangles removed
std::int64_t RemoveDuplicateTriangles(Soup& soup);

/// Result of MakeManifold().
struct ManifoldChanges
{
  std::int64_t FlippedTriangles = 0; ///< number of triangles whose winding was reversed
  std::int64_t AddedPoints = 0;      ///< number of copies of points at which sheets met
};

/// Winds neighbours alike and separates sheets that meet in an edge or a point. Each connected part keeps the winding
/// of the larger part of its area.
ManifoldChanges MakeManifold(Soup& soup);

} // namespace surfsynth
