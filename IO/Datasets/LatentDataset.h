// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field latents of a texture on several triangulations of one surface, for the training of their diffusion
/// [Mitchel2024], section 6.2. Neither VTK nor torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Numbers at the vertices, [V, columns].
using LatentColumns = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One triangulation with the Gaussians of its field latents. Tangent vectors are pairs of numbers, real and imaginary
/// part, in the frames of TangentFrames().
struct LatentSurface
{
  TriangleMesh Mesh;                ///< triangulation, V vertices
  LatentColumns Means;              ///< [V, 2 d], d tangent vectors in turn, without unit
  LatentColumns Deviations;         ///< [V, d], standard deviation of both components of each, 0 or more
  std::vector<std::int32_t> Labels; ///< [V], 0 to 65535, or -1 for a vertex without; or empty
  LatentColumns Directions;         ///< [V, 2], a tangent vector at each vertex, without unit; or empty
};

/// Triangulations of one surface.
struct LatentDataset
{
  std::vector<LatentSurface> Surfaces; ///< at least one
  /// Fingerprint of the model that made the latents (Fingerprint() of FieldLatentModel.h); "" when unknown. No part of
  /// ContentHash().
  std::string Autoencoder;

  /// Number of tangent vectors of a code, d; 0 without a surface.
  std::int64_t Dimension() const;
  /// Largest label and 1; 0 without labels.
  std::int64_t NumberOfLabels() const;
  /// True when the surfaces have directions.
  bool IsDirected() const;
};

/// Checks a dataset. Meshes are not checked.
/// @throws InvalidInput naming the first surface that has no vertex, a number of rows that is not that of its vertices,
/// another number of tangent vectors than the first, a number that is not finite, a negative deviation or a label out of
/// range, or that has labels or directions when the first has none, or none when it has; or when there is no surface.
void CheckDataset(const LatentDataset& dataset);

/// 64-bit hash of all numbers.
std::uint64_t ContentHash(const LatentDataset& dataset);

/// Reads a dataset file: safetensors with the metadata `content` ("field_latents") and `format_version` ("1"), and for
/// each surface k = 0, 1, ... the tensors `surfaces.<k>.points` [V, 3], `surfaces.<k>.means` [V, 2 d] and
/// `surfaces.<k>.deviations` [V, d] of floating-point types, `surfaces.<k>.triangles` [F, 3] integers, and optionally
/// `surfaces.<k>.labels` [V] integers and `surfaces.<k>.directions` [V, 2] of a floating-point type. Means [V, 3 d] and
/// directions [V, 3] are vectors in world axes (those of the latent arrays of points), whose tangent parts are taken. The
/// optional metadata `autoencoder` is LatentDataset::Autoencoder.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format; ModelMismatch
/// when it is no such dataset.
LatentDataset ReadLatentDataset(const std::string& path);

/// Writes a dataset file: points in float64, means, deviations and directions in float32, in the frames.
/// @throws InvalidInput as CheckDataset(), and when the file cannot be written.
void WriteLatentDataset(const std::string& path, const LatentDataset& dataset);

} // namespace surfsynth
