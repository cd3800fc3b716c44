// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The inner loops of inference that are no matrix products. Private to the inference.
///
/// Arrays are float32, row-major [rows, width] and contiguous. Elementary functions are off by less than 1e-6 of the
/// larger of 1 and the exact value; softplus by less than 1e-6 of its value.
#pragma once

#include <cstdint>

namespace surfsynth
{

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

  /// Gradient of a vertex signal [V, width] in faces with these corners, [rows, 3], and hat gradients, [rows, 6].
  void (*FaceGradient)(const float* signal, const std::int32_t* corners, const float* hats, std::int64_t rows,
    std::int64_t width, float* re, float* im);

  /// GELU of the mean of the corners.
  void (*FaceMeanGelu)(
    const float* signal, const std::int32_t* corners, std::int64_t rows, std::int64_t width, float* out);

  /// Adds area * (hx re + hy im) to the rows of @p along, and area * (hy re - hx im) to those of @p across.
  void (*ScatterDivergence)(const float* re, const float* im, const std::int32_t* corners, const float* hats,
    const float* areas, std::int64_t rows, std::int64_t width, float* along, float* across);

  /// Adds area / 3 * ((p1 - p3) re + (p1 + p2) im) to the rows of @p sums at the corners.
  void (*ScatterDots)(const float* p1, const float* p2, const float* p3, const float* re, const float* im,
    const std::int32_t* corners, const float* areas, std::int64_t rows, std::int64_t width, float* sums);

  /// values = tanh(values * scale), scale [width].
  void (*ScaledTanh)(float* values, const float* scale, std::int64_t rows, std::int64_t width);
};

/// The kernels for the widest vectors that this processor has.
const ActivationKernels& BestActivationKernels();

// The variants: the same source compiled for different instruction sets.
extern const ActivationKernels GenericActivationKernels;
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const ActivationKernels Avx2ActivationKernels;
extern const ActivationKernels Avx512ActivationKernels;
#endif

} // namespace surfsynth
