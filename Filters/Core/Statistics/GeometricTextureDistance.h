// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// How alike the relief of two surfaces is, whatever their shape: the distance of the distributions of what their
/// triangles see of their neighbours.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/EdgeFeatures.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

struct GeometricTextureDistanceOptions
{
  double UnitLength = 0.0;          ///< what lengths of the surface are divided by, world units; 0: its mean edge
  double ReferenceUnitLength = 0.0; ///< likewise of the reference
  int Projections = 128;            ///< number of directions, at least 1
  std::uint64_t Seed = 0;           ///< of the directions
};

struct TextureDistance
{
  double Distance = 0.0;       ///< in unit lengths, at least 0
  double StandardError = 0.0;  ///< of Distance, which comes of the number of directions; 0 for a single one
  double MeanEdgeLength = 0.0; ///< of the surface, each edge once, world units
  double ReferenceMeanEdgeLength = 0.0;
};

/// The sliced Wasserstein-1 distance (Rabin et al. 2011) of the edge features of two meshes, lengths over UnitLength.
///
/// A triangle with its 12 features, in each of the three orders that its edges have around it, gives three points of
/// R^12: the distribution of these does not depend on which corner comes first, and a mirror image has another one. For
/// random directions of unit length the points are projected on the direction, and the mean of |a - b| over equal
/// quantiles a, b of both meshes is exact, whatever their numbers of triangles. The distance is the mean of that over the
/// directions. Where all features differ by a vector s that is the same for the three edges, the mean over all directions
/// is Gamma(6) / (sqrt(pi) Gamma(6.5)) |s| = 0.235 |s|.
///
/// All triangles count alike, as a convolution sees them. Zero for meshes that differ by a rotation, a translation or,
/// with UnitLength 0, a scale, up to single precision. O(P (F log F)) time for P directions; the same bits for every
/// number of threads.
/// @throws InvalidInput when a mesh has no triangle, an edge has three triangles or more, an option is not in its range
/// or a feature is not finite; Cancelled
TextureDistance CompareGeometricTextures(const TriangleMesh& surface, const TriangleMesh& reference,
  const GeometricTextureDistanceOptions& options = {}, const Progress& progress = {});

/// The Wasserstein-1 distances along the directions of @p seed, [projections], of two sets of features with a row each
/// for at least one triangle.
/// @throws Cancelled
Eigen::VectorXd SlicedDistances(const EdgeFeatureMatrix& features, const EdgeFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress = {});

} // namespace surfsynth
