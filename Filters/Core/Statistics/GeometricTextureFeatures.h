// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Census of the features of a geometric texture: peaks, how high they are, which of them have merged, and walls.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Statistics/HeightPeaks.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Options of the census. Lengths are in world units.
struct GeometricTextureFeatureOptions
{
  double UnitLength = 0.0;        ///< unit of the dimensionless results; 0: mean edge length of the bare surface
  double MinimumProminence = 0.0; ///< of a peak; 0: half the standard deviation of the heights
  double MergedSaddle = 0.5;      ///< fraction of the height of the lower peak above which a saddle merges two, 0 to 1
  double WallLevel = 0.0;         ///< level of the walls between the quantiles 0.05 and 0.95, to 1; 0: mean height
  double SmoothingLength = 0.0;   ///< of the form where there is no bare surface; 0: a tenth of the root of the area
};

/// Result of MeasureGeometricTextureFeatures(). Heights are over the bare surface, those of peaks over BaseLevel.
struct GeometricTextureFeatures
{
  double Area = 0.0;                    ///< of the bare surface, square world units
  double UnitLength = 0.0;              ///< that was used, world units
  double HeightDeviation = 0.0;         ///< standard deviation of the heights, weighted by area, world units
  double BaseLevel = 0.0;               ///< quantile 0.05 of the heights, weighted by area, world units
  double MinimumProminence = 0.0;       ///< that was used, world units
  std::int64_t NumberOfPeaks = 0;       ///< N
  double PeakDensity = 0.0;             ///< N / Area, 1 / square world units
  double RelativePeakDensity = 0.0;     ///< N UnitLength^2 / Area
  double MeanPeakHeight = 0.0;          ///< mean height of the peaks over BaseLevel, world units
  double PeakHeightVariation = 0.0;     ///< standard deviation of these heights over their mean; 0 for one
  std::int64_t NumberOfMergedPeaks = 0; ///< peaks whose saddle ratio is above MergedSaddle
  double MergedShare = 0.0;             ///< NumberOfMergedPeaks / N; 0 without peaks
  double WallHeight = 0.0;              ///< height of the isoline, world units
  double WallLength = 0.0;              ///< half the length of the isoline, world units
  double WallDensity = 0.0;             ///< WallLength / Area, 1 / world units
  double RelativeWallDensity = 0.0;     ///< WallLength UnitLength / Area
  Eigen::VectorXd Heights;              ///< [V], world units; 0 where no triangle is
  HeightPeaks Peaks;                    ///< peaks, prominences, regions and saddles
};

/// Computes the form of a surface without its relief: each coordinate x becomes S (2 x - S x) with S = (1 + l^2 L)^-1, L the
/// Laplace-Beltrami operator. Of waves of wavelength w a share of 1 - (q / (1 + q))^2, q = (2 pi l / w)^2, is left: 5 % for
/// w = l, 94 % for w = 10 l.
/// @param length l, above 0, world units
/// @throws SolverFailure
TriangleMesh SmoothedForm(const TriangleMesh& mesh, const MeshTopology& topology, double length);

/// Computes the heights of the points of a surface over those of a bare one: signed lengths along its vertex normals, the
/// area-weighted means of the normals of its triangles.
/// @param bare as many points as @p surface
/// @return [V], 0 where no triangle is
Eigen::VectorXd HeightsOver(const TriangleMesh& surface, const TriangleMesh& bare, const MeshTopology& topology);

/// Counts and measures the features of the relief of a surface.
///
/// Peaks are those of FindHeightPeaks() of the heights over the bare surface, or over SmoothedForm() without one. The default
/// of MinimumProminence follows the scale of the surface and of the relief: features that stand on bare ground and fill a
/// share p of the area have a standard deviation of about the root of p / 3 of their height, so that half of it is about a
/// tenth to a quarter of their height. It is at least 1e-6 of the longest side, the rounding of single precision. Heights of
/// peaks count from the quantile 0.05, the ground, so that results do not depend on how high the bare surface lies.
///
/// Walls are where the heights cross the level from below and from above: half the length of the isoline, with heights linear
/// on the triangles of the bare surface, is the length of the ridges of a labyrinth.
///
/// Deterministic: the same bits for every number of threads. O(V log V) and a factorization where there is no bare surface.
/// @param surface valid: finite points, proper triangles, manifold edges
/// @param bare the same triangles with other points; null for none
/// @throws InvalidInput when there is no triangle, an option is not in its range, the triangles differ or the area is not
/// finite; SolverFailure, Cancelled
GeometricTextureFeatures MeasureGeometricTextureFeatures(const TriangleMesh& surface,
  const TriangleMesh* bare = nullptr, const GeometricTextureFeatureOptions& options = {},
  const Progress& progress = {});

} // namespace surfsynth
