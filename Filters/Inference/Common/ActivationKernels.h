// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of networks beside the matrix products: first those of inference, then those of training with their
/// derivatives. Private to Inference and Learning. GELU is that of [Hendrycks2016].
///
/// Arrays are float32, row-major [rows, width] and contiguous. Elementary functions are off by less than 1e-6 of the
/// larger of 1 and the exact value; softplus by less than 1e-6 of its value.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Kernels for one instruction set. z = re + i im are complex numbers; a face has corners [3] and basis gradients [6],
/// in the layout of FaceGradients.
struct ActivationKernels
{
  /// values = GELU(values + bias), bias [width].
  void (*BiasGelu)(float* values, const float* bias, std::int64_t rows, std::int64_t width);

  /// z = z exp(i p) (softplus(s) + 1e-8) with (p, s) = phaseAndScale + bias, [rows, 2 width] and [2 width]; sum = re
  /// + im.
  void (*Modulate)(const float* phaseAndScale, const float* bias, std::int64_t rows, std::int64_t width, float* re,
    float* im, float* sum);

  /// With the three products of a complex product, z = (p1 - p3) + i (p1 + p2), r = sqrt(|z|^2 + 1e-8) and
  /// z = z GELU(r + bias) / (r + 1e-8); sum = re + im.
  void (*ComplexGelu)(const float* p1, const float* p2, const float* p3, const float* bias, std::int64_t rows,
    std::int64_t width, float* re, float* im, float* sum);

  /// Computes the gradient of a vertex signal [V, width] in faces with these @p corners, [rows, 3], and
  /// @p basisGradients, [rows, 6].
  void (*FaceGradient)(const float* signal, const std::int32_t* corners, const float* basisGradients, std::int64_t rows,
    std::int64_t width, float* re, float* im);

  /// out = GELU(mean of the three corners' values).
  void (*FaceMeanGelu)(
    const float* signal, const std::int32_t* corners, std::int64_t rows, std::int64_t width, float* out);

  /// Adds area * (bx re + by im) to the rows of @p along at the corners, and area * (by re - bx im) to those of
  /// @p across, with (bx, by) the basis gradient of the corner.
  void (*ScatterDivergence)(const float* re, const float* im, const std::int32_t* corners, const float* basisGradients,
    const float* areas, std::int64_t rows, std::int64_t width, float* along, float* across);

  /// Adds area / 3 * ((p1 - p3) re + (p1 + p2) im) to the rows of @p sums at the corners.
  void (*ScatterDots)(const float* p1, const float* p2, const float* p3, const float* re, const float* im,
    const std::int32_t* corners, const float* areas, std::int64_t rows, std::int64_t width, float* sums);

  /// values = tanh(values * scale), scale [width].
  void (*ScaledTanh)(float* values, const float* scale, std::int64_t rows, std::int64_t width);

  /// Computes gradient and mean of a vertex signal [V, width] in faces with these @p corners, [rows, 3], and
  /// @p basisGradients, [rows, 6].
  void (*GatherFaces)(const float* signal, const std::int32_t* corners, const float* basisGradients, std::int64_t rows,
    std::int64_t width, float* re, float* im, float* mean);

  /// out_v = sum over the entries e of vertex v of wx_e re_f + wy_e im_f + wm_e mean_f, f the face of e. Entries of
  /// vertex v are offsets[v] to offsets[v + 1]; a signal that is null counts as 0. Writes @p rows vertices from
  /// @p first on.
  void (*GatherVertices)(const float* re, const float* im, const float* mean, const std::int32_t* offsets,
    const std::int32_t* faces, const float* wx, const float* wy, const float* wm, std::int64_t first, std::int64_t rows,
    std::int64_t width, float* out);
};

/// Returns the kernels for CurrentInstructionSet().
const ActivationKernels& BestActivationKernels();

// The variants: the same source compiled for different instruction sets.
extern const ActivationKernels GenericActivationKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const ActivationKernels Avx2ActivationKernels;   ///< for AVX2
extern const ActivationKernels Avx512ActivationKernels; ///< for AVX-512
#endif

} // namespace surfsynth
