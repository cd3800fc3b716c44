// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of diffusion in field latents [Mitchel2024] beside the matrix products. Private to Inference and Learning.
///
/// Arrays are float32, row-major. A row of C complex channels is [real parts, imaginary parts], 2 C numbers. Results of
/// the variants differ in last bits only.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Hidden channels of the filters of field convolutions.
constexpr std::int64_t FilterChannels = 8;

/// One level of a surface and its features, as GatherFields() reads them. Complex numbers are pairs of numbers.
struct FieldNeighborhoods
{
  const std::int32_t* Start;   ///< [V + 1]
  const std::int32_t* Sources; ///< [E]
  const float* Logarithms;     ///< [E, 2], of the source, in the frame of the vertex
  const float* Transport;      ///< [E, 2], from the source to the vertex
  const float* Weights;        ///< [E]
  const float* Centroids;      ///< [V, 2], directions of the rings' centroids, in the frames of the vertices, or null
  const float* Directions;     ///< [V, 2], in the frames of the vertices, or null
  const std::int32_t* Shares;  ///< [V], row of FieldFilter::Shares of each vertex, or null: row 0
};

/// Weights of one filter up to the last hidden layer, K = FilterChannels.
struct FieldFilter
{
  const float* Shares;    ///< [*, K], bias and embedding in the first layer
  const float* Radius;    ///< [K], weights of the length of the logarithm
  const float* Aligned;   ///< [2, K], weights of cosine and sine of the aligned angle
  const float* Centroids; ///< [2, K], weights of cosine and sine times the length of the aligned centroid
  const float* Directed;  ///< [2, K], weights of cosine and sine times the length of the aligned direction
  const float* Hidden;    ///< [K, K], second layer, by outputs
  const float* Bias;      ///< [K], of the second layer
};

/// Edges of one level by their sources.
struct FieldSources
{
  const std::int32_t* Start;   ///< [V + 1], first edge of each source
  const std::int32_t* Edges;   ///< [E], number of the edge in FieldNeighborhoods
  const std::int32_t* Targets; ///< [E], vertex whose neighborhood the edge belongs to
};

/// Derivatives by the weights of a filter, shapes as in FieldFilter, that GatherFieldsGradient() adds to.
struct FieldFilterGradient
{
  float* Shares;
  float* Radius;
  float* Aligned;
  float* Centroids;
  float* Directed;
  float* Hidden;
  float* Bias;
};

/// Kernels for one instruction set.
struct LatentDiffusionKernels
{
  /// Sums over the neighborhoods of the vertices [first, first + rows): with X the transported feature of channel c and
  /// h the outputs of the second layer of the filter (both layers with ReLU), whose arguments are the length and the
  /// angle of conj(X / |X|) times the logarithm, and conj(X / |X|) times the centroid and the direction,
  /// out = sum of weight h(k, c) X(c).
  /// @param features [V, 2 C] @param units [V, 2 C], their directions: see Units() @param out [rows, K 2 C]
  void (*GatherFields)(const FieldNeighborhoods& at, const FieldFilter& filter, const float* features,
    const float* units, std::int64_t first, std::int64_t rows, std::int64_t channels, float* out);

  /// Derivatives of GatherFields() by the features of the sources [first, first + rows), those through their directions
  /// included, and by the weights of the filter. Each source reads the derivatives of its neighbors, so that no two
  /// threads write to the same place; the hidden layers are computed again.
  /// @param dSums [V, K 2 C], derivatives by the results @param dFeatures [rows, 2 C], derivatives by the features
  void (*GatherFieldsGradient)(const FieldNeighborhoods& at, const FieldSources& sources, const FieldFilter& filter,
    const float* features, const float* units, const float* dSums, std::int64_t first, std::int64_t rows,
    std::int64_t channels, float* dFeatures, const FieldFilterGradient& gradient);

  /// units = x / sqrt(|x|^2 + 1e-6), x [rows, 2 C].
  void (*Units)(const float* x, std::int64_t rows, std::int64_t channels, float* units);

  /// sums = sum over the rows of |x|^2, sums [C].
  void (*Squares)(const float* x, std::int64_t rows, std::int64_t channels, float* sums);
};

/// Returns the kernels for CurrentInstructionSet().
const LatentDiffusionKernels& BestLatentDiffusionKernels();

// The variants: the same source compiled for different instruction sets.
extern const LatentDiffusionKernels GenericLatentDiffusionKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const LatentDiffusionKernels Avx2LatentDiffusionKernels;   ///< for AVX2
extern const LatentDiffusionKernels Avx512LatentDiffusionKernels; ///< for AVX-512
#endif

} // namespace surfsynth
