// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Distance of two surfaces that need not have anything in common but their place.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Distances from the places of one surface to the nearest places of another, weighted by area; world units.
struct DistanceSummary
{
  double Mean = 0.0;         ///< arithmetic mean
  double RMS = 0.0;          ///< root of the mean square
  double Percentile95 = 0.0; ///< distance that 95 percent of the area do not exceed
  double Maximum = 0.0;      ///< one-sided Hausdorff distance: of samples and vertices
};

/// Distance of two surfaces in both directions [Aspert2002].
struct SurfaceDistance
{
  DistanceSummary FirstToSecond; ///< from the places of the first surface
  DistanceSummary SecondToFirst; ///< from the places of the second surface
  /// Of the places of both surfaces together, each surface with half of the weight; Maximum is the Hausdorff distance.
  DistanceSummary Symmetric;
};

/// Measures the distance of two surfaces at samples that are spread evenly over the area of each: the k-th lies in the k-th of
/// equal parts of the area, and those of one triangle follow a sequence of low discrepancy (additive recurrence with the
/// steps 1 / g and 1 / g^2, g^3 = g + 1), which the seed shifts. Maximum also looks at all vertices of triangles; it is a
/// lower bound.
/// @param find search for nearest places
/// @param samples number of samples on each surface, at least 1
/// @throws InvalidInput for a surface without area, or with points that are not finite; Cancelled
SurfaceDistance ComputeSurfaceDistance(const TriangleMesh& first, const TriangleMesh& second, const PlaceFinder& find,
  std::int64_t samples = 100000, std::uint64_t seed = 0, const Progress& progress = {});

/// Computes the mean angle between the normals of two surfaces, in degrees, 0 to 180: at such samples of both surfaces, with
/// equal weight, between the normal of the triangle and that of the nearest place of the other surface. Triangles without area
/// have no normal, and count as 90 degrees.
/// @throws InvalidInput for a surface without area, or with points that are not finite
double MeanNormalAngle(const TriangleMesh& first, const TriangleMesh& second, const PlaceFinder& find,
  std::int64_t samples = 100000, std::uint64_t seed = 0);

/// Returns the distances of @p points, [N, 3], to the nearest places of @p mesh, [N].
Eigen::VectorXd DistancesTo(const TriangleMesh& mesh, const PointMatrix& points, const PlaceFinder& find);

} // namespace surfsynth
