// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Repair of triangle meshes. Private to the mesh processing.
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

/// Options of RepairSurface().
struct RepairOptions
{
  bool MergePoints = true;              ///< merge points within MergeTolerance of each other
  double MergeTolerance = 0.0;          ///< world units, at least 0; 0: equal coordinates
  bool RemoveSelfIntersections = false; ///< replace triangles that cross by patches that do not
  double LargestHole = 0.0;             ///< holes of at most this extent are closed, world units; 0: none
  bool KeepLargestComponent = false;    ///< keep only the component of the largest area
  double SmallestComponent = 0.0;       ///< components below this fraction of the largest one's area are removed
  PlaceFinder Finder;                   ///< search function for RepairedSurface::PlaceOfPoint
  bool OrientOutward = true;            ///< normals of a closed surface point outwards
};

/// Report of a repair: steps in their order, with the number of changes of each. Steps without a change are left out.
using RepairReport = std::vector<std::pair<std::string, std::int64_t>>;

/// A repaired surface, and its places on the input mesh.
struct RepairedSurface
{
  TriangleMesh Mesh;                      ///< the result
  std::vector<SurfacePlace> PlaceOfPoint; ///< [V'] on the input mesh, for the interpolation of point attributes
  std::vector<Index> OriginOfTriangle;    ///< [F'] triangle of the input mesh nearest to the centre of each triangle
  std::vector<bool> IsFilling;            ///< [F'] true for triangles that close a hole
  RepairReport Report;                    ///< changes
};

/// Repairs a surface: merges points, removes duplicate triangles, separates sheets that meet in an edge or a point,
/// winds triangles alike, removes triangles without area, components and, if asked, self-intersections, and closes
/// holes.
///
/// The result is manifold, consistently wound and without degenerate triangles, and closed when no hole exceeds
/// LargestHole. Points keep their coordinates, except where sheets were separated: those move by a hundredth of an
/// edge. Points keep their order unless some are merged.
///
/// @param losses losses of the conversion to @p mesh: the first lines of the report.
/// @param stop asks the call to end early with a Cancelled; may be null.
/// @throws InvalidInput when no triangle is left; SolverFailure when a defect cannot be removed; Cancelled
RepairedSurface RepairSurface(const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options,
  const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
