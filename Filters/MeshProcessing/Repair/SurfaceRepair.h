// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Repair of triangle meshes. Private to the meshing module.
#pragma once

#include "Core/Mesh/ConversionLosses.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

/// What RepairSurface() may do.
struct RepairOptions
{
  bool MergePoints = true;              ///< make points within MergeTolerance of each other one
  double MergeTolerance = 0.0;          ///< world units; 0: equal coordinates
  bool RemoveSelfIntersections = false; ///< replace triangles that cross by patches that do not
  double LargestHole = 0.0;             ///< holes of at most this extent are closed, world units; 0: none
  bool KeepLargestComponent = false;    ///< only the component of the largest area stays
  double SmallestComponent = 0.0;       ///< components below this fraction of the largest one's area go
  PlaceFinder Finder;                   ///< search structure for RepairedSurface::PlaceOfPoint
  bool OrientOutward = true;            ///< a closed surface gets normals that point out of what it encloses
};

/// What was done: text and how often, in the order of the steps. Steps that had nothing to do are left out.
using RepairReport = std::vector<std::pair<std::string, std::int64_t>>;

/// A repaired surface, and where on the broken one it lies.
struct RepairedSurface
{
  TriangleMesh Mesh;
  std::vector<SurfacePlace> PlaceOfPoint; ///< [V'] on the input mesh, for the interpolation of point attributes
  std::vector<Index> OriginOfTriangle;    ///< [F'] triangle of the input mesh nearest to the centre of each triangle
  std::vector<bool> IsFilling;            ///< [F'] true for triangles that close a hole
  RepairReport Report;
};

/// Repairs a surface: merges points, drops duplicate triangles, takes sheets that meet in an edge or a point apart, winds
/// triangles alike, removes triangles without area, components and, if asked, self-intersections, and closes holes.
///
/// What comes out is manifold, consistently wound and without degenerate triangles, and closed when LargestHole is not
/// exceeded anywhere; points keep their coordinates, but for those where sheets were taken apart, which move by a
/// hundredth of an edge, and, as long as none is merged, their order.
///
/// @param losses of the conversion to @p mesh: the first lines of the report.
/// @param stop asks the call to end early with a Cancelled; may be null.
/// @throws InvalidInput when no triangle is left; SolverFailure when a defect cannot be removed; Cancelled
RepairedSurface RepairSurface(const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options,
  const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
