// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Isotropic remeshing of a surface [Botsch2004]. Private to the mesh processing.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Options of RemeshIsotropically().
struct RemeshingOptions
{
  double EdgeLength = 0.0;              ///< target edge length, world units, larger than 0
  std::vector<double> PointEdgeLengths; ///< [V] target edge length at each point instead, all larger than 0; or empty
  std::int64_t NumberOfPoints = 0;      ///< when larger than 0: edge lengths are scaled so that this many points result
  /// True: EdgeLength is the mean edge length of the result, within about 2 per cent if curves and the shape allow it;
  /// PointEdgeLengths are mean lengths near their points, which are not measured. False: they are targets, and the means are
  /// about 8 per cent below. Not used with NumberOfPoints.
  bool MatchMeanEdgeLength = false;
  double MaximumNumberOfPoints = 1e7; ///< limit of the points that are to be expected, checked before the work
  double FeatureAngle = 180.0;        ///< edges whose normals differ by more degrees are kept as creases
  bool KeepBoundaryPoints = false;    ///< every point of the boundary keeps its place
  int NumberOfIterations = 3;         ///< rounds of splits, collapses, flips and relaxation, at least 1
  int NumberOfRelaxationSteps = 1;    ///< steps of tangential relaxation in each round
  /// [V] class of each point. Points of the same coordinates become one point unless their classes differ: then the
  /// edges between them are a seam of the attributes, which is kept as a curve, with a point on either side.
  std::vector<Index> PointClasses;
  PlaceFinder Finder;      ///< search function; needed with FindPlaces or FindOrigins
  bool FindPlaces = true;  ///< fill PlaceOfPoint, which point attributes need
  bool FindOrigins = true; ///< fill OriginOfTriangle, which cell attributes need
};

/// A remeshed surface, and its places on the input mesh.
struct RemeshedSurface
{
  TriangleMesh Mesh;                      ///< the result
  std::vector<SurfacePlace> PlaceOfPoint; ///< [V'] on the input mesh, for the interpolation of point attributes
  std::vector<Index> OriginOfTriangle;    ///< [F'] triangle of the input mesh nearest to the centre of each triangle
};

/// Remeshes by rounds of edge splits (above 4/3 of the target length), collapses (below 4/5), flips towards valence 6,
/// tangential relaxation and projection to the input surface [Botsch2004]. With one target length this is CGAL's
/// isotropic_remeshing(); with lengths that vary from point to point, RemeshAdaptively() does the same steps.
///
/// Boundaries, creases and attribute seams are resampled along themselves: afterwards their points are put back onto
/// the curve; points where such curves meet, end or turn sharply stay.
///
/// @param mesh manifold edges and vertices, consistent winding.
/// @param stop asks the call to end early, between two rounds, with a Cancelled; may be null.
/// @throws InvalidInput when more than MaximumNumberOfPoints are to be expected, or an EdgeLength is longer than the
/// surface; Cancelled
RemeshedSurface RemeshIsotropically(
  const TriangleMesh& mesh, const RemeshingOptions& options, const std::atomic<bool>* stop = nullptr);

/// Number of points to expect: half of the triangles with the edge lengths of @p options that cover the mesh. NumberOfPoints
/// and MatchMeanEdgeLength play no part.
double ExpectedNumberOfPoints(const TriangleMesh& mesh, const RemeshingOptions& options);

} // namespace surfsynth
