// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of convolutions over triangles [Hertz2020] beside the matrix products. Private to the inference.
///
/// Arrays are float32, row-major. Results of the variants differ in last bits only.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Kernels for one instruction set.
struct FaceKernels
{
  /// The first convolution: out[row] = bias + max over 3 edges of features[row, edge] * matrix; features [rows, 3 x 4],
  /// matrix [4, width], bias [width], out [rows, width].
  void (*EdgeMaps)(
    const float* features, const float* matrix, const float* bias, std::int64_t rows, std::int64_t width, float* out);

  /// Completes a convolution from its two products, which lie side by side in rows of 2 width: that with the triangle
  /// itself and that with it as a neighbour. Adds the bias and the largest of the second products of three neighbours
  /// to the first product, in place, of the rows from @p first on. @p neighbors [*, 3] and @p products are those of
  /// all triangles.
  void (*GatherMax)(const std::int32_t* neighbors, const float* bias, std::int64_t first, std::int64_t rows,
    std::int64_t width, float* products);

  /// Adds values and their squares to @p sums and @p squares, [width]; rows are @p stride numbers apart.
  void (*AddMoments)(
    const float* values, std::int64_t stride, std::int64_t rows, std::int64_t width, double* sums, double* squares);

  /// out = leaky((values - mean) * scale) with a slope of 0.2 below 0. Rows of @p values are @p stride numbers apart;
  /// rows of @p out are contiguous. @p values and @p out may be the same array when rows of both are contiguous.
  void (*Normalize)(const float* values, std::int64_t stride, const float* mean, const float* scale, std::int64_t rows,
    std::int64_t width, float* out);
};

/// Returns the kernels for CurrentInstructionSet().
const FaceKernels& BestFaceKernels();

// The variants: the same source compiled for different instruction sets.
extern const FaceKernels GenericFaceKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const FaceKernels Avx2FaceKernels;   ///< for AVX2
extern const FaceKernels Avx512FaceKernels; ///< for AVX-512
#endif

} // namespace surfsynth
