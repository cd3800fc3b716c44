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
  double LargestHole = 0.0;          ///< holes of at most this extent are closed, world units; 0: LargestHoleFraction
  double LargestHoleFraction = 0.0;  ///< the same as a fraction of the diagonal of the bounding box; 0: none
  bool KeepLargestComponent = false; ///< keep only the component of the largest area
  double SmallestComponent = 0.0;    ///< components below this fraction of the largest one's area are removed
  PlaceFinder Finder;                ///< search function for RepairedSurface::PlaceOfPoint
  bool OrientOutward = true;         ///< normals of a closed surface point outwards
  double MaximumLoss = 0.05;         ///< largest fraction of area, volume or components that is lost without a warning
  bool Strict = false;               ///< throw where there would be a warning
  bool SinglePrecision = false;      ///< round points to float32, the precision of the result
};

/// Report of a repair: steps in their order, with the number of changes of each. Steps without a change are left out.
using RepairReport = std::vector<std::pair<std::string, std::int64_t>>;

/// A measure of the surface before and after a repair.
struct RepairMeasure
{
  std::string Name;    ///< Area, Volume, Components, IntersectingTriangles
  double Before = 0.0; ///< after duplicate triangles were removed and sheets separated
  double After = 0.0;  ///< the result; Area without the triangles that close holes
};

/// Defects that a repair left, and its losses.
struct RepairOutcome
{
  std::int64_t IntersectingTriangles = 0; ///< number of triangles that still intersect others, where they were removed
  std::int64_t OpenHoles = 0;             ///< number of holes that were to be closed and are open
  double AreaLoss = 0.0;        ///< fraction of the area lost, from 0 to 1; components removed on request excepted
  double VolumeLoss = 0.0;      ///< fraction of the volume lost, from 0 to 1; 0 unless closed before and after
  double ComponentChange = 0.0; ///< components lost or gained, as a fraction of those before
  std::vector<RepairMeasure> Measures; ///< Volume only when closed before and after, IntersectingTriangles when asked
  std::vector<std::string> Warnings;   ///< sentences; empty when nothing is left and no loss exceeds MaximumLoss
};

/// A repaired surface, and its places on the input mesh.
struct RepairedSurface
{
  TriangleMesh Mesh;                      ///< the result
  std::vector<SurfacePlace> PlaceOfPoint; ///< [V'] on the input mesh, for the interpolation of point attributes
  std::vector<Index> OriginOfTriangle;    ///< [F'] triangle of the input mesh nearest to the centre of each triangle
  std::vector<bool> IsFilling;            ///< [F'] true for triangles that close a hole
  RepairReport Report;                    ///< changes
  RepairOutcome Outcome;                  ///< what is left and what was lost
};

/// Repairs a surface: merges points, removes duplicate triangles, separates sheets that meet in an edge or a point,
/// winds triangles alike, removes triangles without area, components and, if asked, self-intersections, and closes
/// holes. Repeats these steps until they change nothing, so that a repair of the result returns the result. (With a
/// MergeTolerance of more than a tenth of the edges it may merge points that the repair separated or added within that
/// tolerance.)
///
/// The result is manifold, consistently wound and without degenerate triangles, and closed when no hole exceeds
/// LargestHole. Points keep their coordinates, except where sheets were separated: those move by a hundredth of an
/// edge, or by one and a half MergeTolerance up to a quarter of an edge. Points keep their order unless some are merged.
/// A removal of self-intersections that would lose more than MaximumLoss, beside the area of the intersecting triangles, is
/// refused, and with RemoveSelfIntersections holes stay open that only intersecting triangles could close;
/// RepairOutcome::Warnings counts both.
///
/// @param losses losses of the conversion to @p mesh: the first lines of the report.
/// @param stop asks the call to end early with a Cancelled; may be null.
/// @throws InvalidInput when no triangle is left; SolverFailure when a defect cannot be removed, or with Strict the
/// warnings; Cancelled
RepairedSurface RepairSurface(const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options,
  const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
