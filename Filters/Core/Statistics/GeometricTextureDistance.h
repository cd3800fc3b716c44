// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Distance of the geometric textures of two surfaces of any shape: the sliced Wasserstein distance [Rabin2011]
/// [Bonneel2015] of the distributions of their edge features, or of the features of larger neighborhoods.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Core/Operators/RingFeatures.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Options of the distance.
struct GeometricTextureDistanceOptions
{
  double UnitLength = 0.0;          ///< divisor of the lengths of the surface, world units; 0: its mean edge length
  double ReferenceUnitLength = 0.0; ///< divisor of the lengths of the reference; 0: its mean edge length
  int Projections = 128;            ///< number of directions, at least 1
  std::uint64_t Seed = 0;           ///< seed of the directions
  int Rings = 1; ///< 1: edge features of the triangles; 2 to 16: ring features of the vertices, of so many rings
};

/// Result of CompareGeometricTextures().
struct TextureDistance
{
  double Distance = 0.0;                ///< in unit lengths, at least 0
  double StandardError = 0.0;           ///< error of Distance by the number of directions; 0 for a single direction
  double MeanEdgeLength = 0.0;          ///< mean edge length of the surface, each edge once, world units
  double ReferenceMeanEdgeLength = 0.0; ///< mean edge length of the reference, likewise
};

/// Computes the sliced Wasserstein-1 distance [Rabin2011] of the edge features of two meshes, lengths over UnitLength, or,
/// with Rings above 1, of their ring features.
///
/// Edge features see a triangle and its three neighbors. A triangle with its 12 features (see ComputeEdgeFeatures()), in
/// each of the three orders of its edges around it, gives three points of R^12. Their distribution does not depend on the
/// choice of the first corner, and differs from that of a mirror image. Triangles on a boundary do not count, unless all lie
/// there. For random directions of unit length the points are projected on the direction; the mean of |a - b| over equal
/// quantiles a, b of both meshes is exact for any numbers of triangles. The distance is its mean over the directions. For features that differ by one vector s, the same for the three edges, the mean over all
/// directions is Gamma(6) / (sqrt(pi) Gamma(6.5)) |s| = 0.235 |s|.
///
/// Ring features (see ComputeRingFeatures()) of R rings see what is R edges around a vertex: the size, height and spacing of
/// the features of the surface that are smaller than that. Each vertex whose rings are whole is one point of R^(6 R).
///
/// All that count have the same weight, as in a convolution. Zero for meshes that differ by a rotation, a
/// translation or, with UnitLength 0, a scale, up to single precision. O(P (F log F)) time for P directions and one ring,
/// O(P V (R + log V)) for R rings; the same bits for every number of threads.
/// @throws InvalidInput when a mesh has no triangle, an edge has three triangles or more, an option is not in its range
/// or a feature is not finite; Cancelled
TextureDistance CompareGeometricTextures(const TriangleMesh& surface, const TriangleMesh& reference,
  const GeometricTextureDistanceOptions& options = {}, const Progress& progress = {});

/// Computes the Wasserstein-1 distance of two sets of features along each direction of @p seed.
/// @param features [F, 12], F at least 1
/// @param reference [F', 12], F' at least 1
/// @return [projections]
/// @throws Cancelled
Eigen::VectorXd SlicedDistances(const EdgeFeatureMatrix& features, const EdgeFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress = {});

/// The same for features of vertices, in which no order is arbitrary.
/// @param features [N, C], N at least 1
/// @param reference [N', C], N' at least 1
/// @return [projections]
/// @throws Cancelled
Eigen::VectorXd SlicedDistances(const RingFeatureMatrix& features, const RingFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress = {});

} // namespace surfsynth
