// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Remeshing a surface with triangles of even shape. Private to the meshing module.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// What RemeshIsotropically() aims at.
struct RemeshingOptions
{
  double EdgeLength = 0.0;              ///< target edge length, world units, larger than 0
  std::vector<double> PointEdgeLengths; ///< [V] target edge length at each point instead, all larger than 0; or empty
  std::int64_t NumberOfPoints = 0;      ///< when larger than 0: edge lengths are scaled so that this many points result
  /// Whether EdgeLength is that of the result on average, within about 2 per cent where curves and the shape allow it,
  /// and not the target, which edges stay about 8 per cent below. Not used with PointEdgeLengths or NumberOfPoints.
  bool MatchMeanEdgeLength = false;
  double FeatureAngle = 180.0;     ///< edges whose normals differ by more degrees are kept as creases
  bool KeepBoundaryPoints = false; ///< every point of the boundary stays, where it is
  int NumberOfIterations = 3;      ///< rounds of splits, collapses, flips and relaxation, at least 1
  int NumberOfRelaxationSteps = 1; ///< steps of tangential relaxation in each round
  /// [V] a class for each point. Points of the same coordinates become one point, unless their classes differ: then the
  /// edges between them are a seam of the attributes, which is kept as a curve, with a point on either side.
  std::vector<Index> PointClasses;
  PlaceFinder Finder;      ///< search structure; needed where FindPlaces or FindOrigins is set
  bool FindPlaces = true;  ///< fill PlaceOfPoint, which point attributes need
  bool FindOrigins = true; ///< fill OriginOfTriangle, which cell attributes need
};

/// A remeshed surface, and where on the old one it lies.
struct RemeshedSurface
{
  TriangleMesh Mesh;
  std::vector<SurfacePlace> PlaceOfPoint; ///< [V'] on the input mesh, for the interpolation of point attributes
  std::vector<Index> OriginOfTriangle;    ///< [F'] triangle of the input mesh nearest to the centre of each triangle
};

/// Remeshes by rounds of edge splits (above 4/3 of the target length), collapses (below 4/5), flips towards valence 6,
/// tangential relaxation and projection to the input surface (Botsch and Kobbelt, "A Remeshing Approach to
/// Multiresolution Modeling", 2004). With one target length this is CGAL's isotropic_remeshing(); where the length varies
/// from point to point, RemeshAdaptively() does the same steps.
///
/// Boundaries, creases and attribute seams are resampled along themselves: afterwards their points are put back onto the
/// curve; points where such curves meet, end or turn sharply stay.
///
/// @param mesh manifold edges and vertices, consistent winding.
/// @param stop asks the call to end early, between two rounds, with a Cancelled; may be null.
/// @throws InvalidInput, Cancelled
RemeshedSurface RemeshIsotropically(
  const TriangleMesh& mesh, const RemeshingOptions& options, const std::atomic<bool>* stop = nullptr);

/// Mean length of the edges of the mesh's triangles (inner edges count twice), world units.
double MeanEdgeLength(const TriangleMesh& mesh);

} // namespace surfsynth
