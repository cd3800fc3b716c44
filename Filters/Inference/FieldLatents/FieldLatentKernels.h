// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of field latents [Mitchel2024] beside the matrix products, with the derivatives that training needs.
/// Private to Inference and Learning.
///
/// Arrays are float32, row-major. A row of C complex channels is [real parts, imaginary parts], 2 C numbers. A ring is
/// the consecutive rows of its tokens. Logarithms are [rows, 2], colors [rows, 3]. Results of the variants differ in last
/// bits only.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Kernels for one instruction set.
struct FieldLatentKernels
{
  /// Equation 21: out = (W color + b) log; W^T [3, 2 C], b [2 C], out [rows, 2 C].
  void (*Lift)(const float* colors, const float* logarithms, const float* weights, const float* bias, std::int64_t rows,
    std::int64_t channels, float* out);

  /// out = SiLU(|log| w + b), the first layer of the filter of equation 22; w and b [C], out [rows, C].
  void (*Radii)(const float* logarithms, const float* weights, const float* bias, std::int64_t rows,
    std::int64_t channels, float* out);

  /// Equation 22, divided by the number of rows: out = mean of log (W color + b) (f + c); W^T [3, 2 C], b [2 C], f [rows,
  /// 2 C], c [2 C], out [2 C].
  void (*Gather)(const float* colors, const float* logarithms, const float* weights, const float* bias,
    const float* filter, const float* filterBias, std::int64_t rows, std::int64_t channels, float* out);

  /// Equation 20 on one ring: scale = 1 / sqrt(mean |x|^2 + delta), out = a x scale; a [2 C], delta and scale [C].
  void (*Normalize)(const float* x, const float* a, const float* delta, std::int64_t rows, std::int64_t channels,
    float* scale, float* out);
  /// Computes the derivatives by x from those by the result of Normalize(), and adds those by a [2 C] and delta [C].
  /// Scratch is [C].
  void (*NormalizeGradient)(const float* x, const float* a, const float* scale, const float* gradient,
    std::int64_t rows, std::int64_t channels, float* scratch, float* dx, float* da, float* dDelta);

  /// Equation 19 with delta = 1e-3 on rows [K real, K imaginary, Q real, Q imaginary], 4 C numbers; out [rows, 2 C].
  void (*Neuron)(const float* keysAndQueries, std::int64_t rows, std::int64_t channels, float* out);
  /// As Neuron(), added to @p out.
  void (*AddNeuron)(const float* keysAndQueries, std::int64_t rows, std::int64_t channels, float* out);
  /// Computes the derivatives by the input of Neuron() from those by its result.
  void (*NeuronGradient)(const float* keysAndQueries, const float* gradient, std::int64_t rows, std::int64_t channels,
    float* dKeysAndQueries);

  /// Softmax of scale x over the rows, for each column. Scratch is [2 columns].
  void (*ColumnSoftmax)(float* values, float scale, std::int64_t rows, std::int64_t columns, float* scratch);
  /// Replaces the derivatives by the result p of ColumnSoftmax() by those by its input. Scratch is [columns].
  void (*ColumnSoftmaxGradient)(
    const float* probabilities, float scale, std::int64_t rows, std::int64_t columns, float* scratch, float* gradient);

  /// values = SiLU(values + bias), bias [width].
  void (*BiasSilu)(float* values, const float* bias, std::int64_t rows, std::int64_t width);

  /// First layer of the decoder: out = SiLU(F + x A + y B) with (F, A, B) the row of @p shares, [*, 3 width], that @p ids
  /// names, and (x, y) the logarithm.
  void (*LogarithmicTexels)(const float* shares, const std::int32_t* ids, const float* logarithms, std::int64_t rows,
    std::int64_t width, float* out);
  /// The same with barycentric coordinates: out = SiLU(sum of b_k F_k + bias), F_k the rows of @p shares, [*, width],
  /// that the three ids name, and b [rows, 3].
  void (*BarycentricTexels)(const float* shares, const std::int32_t* ids, const float* barycentric, const float* bias,
    std::int64_t rows, std::int64_t width, float* out);
};

/// Returns the kernels for CurrentInstructionSet().
const FieldLatentKernels& BestFieldLatentKernels();

// The variants: the same source compiled for different instruction sets.
extern const FieldLatentKernels GenericFieldLatentKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const FieldLatentKernels Avx2FieldLatentKernels;   ///< for AVX2
extern const FieldLatentKernels Avx512FieldLatentKernels; ///< for AVX-512
#endif

} // namespace surfsynth
