// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of the training of a PoissonNet [Maesumi2025] beside the matrix products, with their derivatives. Private
/// to Inference and Learning.
///
/// Arrays are float32, row-major and contiguous. A complex row has 2 width numbers: real parts, then imaginary parts, so
/// that a complex map is one real matrix product. A face has corners [3] and basis gradients [6], in the layout of
/// FaceGradients. GELU is that of [Hendrycks2016]. Elementary functions have the errors of ActivationKernels.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Faces of a tile.
struct FaceRows
{
  const std::int32_t* Corners; ///< [rows, 3], vertices of the mesh or of a patch
  const float* BasisGradients; ///< [rows, 6]
  const float* Areas;          ///< [rows]
  std::int64_t Rows;           ///< number of faces
};

/// Kernels for one instruction set. @c width is the number of channels.
struct GradientKernels
{
  /// Sets each row to @p row, [width].
  void (*FillRows)(const float* row, std::int64_t rows, std::int64_t width, float* out);
  /// Adds the sums of the columns of @p values to @p sums, [width].
  void (*AddColumnSums)(const float* values, std::int64_t rows, std::int64_t width, float* sums);

  /// out = GELU(in).
  void (*Gelu)(const float* in, std::int64_t count, float* out);
  /// The same, and the derivatives, by which a gradient of the output is multiplied. @p slopes may be @p in
  void (*GeluWithSlopes)(const float* in, std::int64_t count, float* out, float* slopes);
  /// values *= factors.
  void (*Scale)(const float* factors, std::int64_t count, float* values);

  /// values += scale * terms, scale [width].
  void (*AddScaled)(const float* terms, const float* scale, std::int64_t rows, std::int64_t width, float* values);
  /// byTerms = scale * gradient, and adds the sums over the rows of gradient * terms to @p byScale.
  void (*AddScaledBackward)(const float* gradient, const float* terms, const float* scale, std::int64_t rows,
    std::int64_t width, float* byTerms, float* byScale);

  /// Gradients of a vertex signal [V, width] in faces: complex rows.
  void (*Gradient)(const float* signal, const FaceRows& faces, std::int64_t width, float* z);
  /// Means of the three corners' values.
  void (*CornerMean)(const float* signal, const FaceRows& faces, std::int64_t width, float* mean);
  /// Adds the transposes of Gradient() and, unless @p mean is null, of CornerMean() to the rows of @p sums at the corners,
  /// [points, width] or [points, 2 width].
  void (*AddTransposed)(const float* z, const float* mean, const FaceRows& faces, std::int64_t width, float* sums);

  /// out = z exp(i p) (softplus(s) + 1e-8), (p, s) = phaseAndScale, [rows, 2 width].
  void (*Modulate)(const float* phaseAndScale, const float* z, std::int64_t rows, std::int64_t width, float* out);
  /// The same; replaces (p, s) by the real and imaginary parts of z's factor, and sets slopes [rows, width], the derivatives of
  /// the logarithm of its modulus by s.
  void (*ModulateWithSlopes)(
    float* phaseAndScale, const float* z, std::int64_t rows, std::int64_t width, float* out, float* slopes);
  /// Replaces the factors, which ModulateWithSlopes() left with @p slopes, by the derivative by (p, s), and @p gradient, of
  /// the output @p out, by that by z.
  void (*ModulateBackward)(
    const float* out, const float* slopes, std::int64_t rows, std::int64_t width, float* factors, float* gradient);

  /// With r = sqrt(|z|^2 + 1e-8): out = z GELU(r + bias) / (r + 1e-8), bias [width].
  void (*ComplexGelu)(const float* z, const float* bias, std::int64_t rows, std::int64_t width, float* out);
  /// The same, and the numbers of ComplexGeluBackward(): slopes [rows, 3 width], z's factor f = GELU(r + bias) / (r + 1e-8),
  /// and its derivatives by the bias, and by r, divided by r.
  void (*ComplexGeluWithSlopes)(
    const float* z, const float* bias, std::int64_t rows, std::int64_t width, float* out, float* slopes);
  /// Replaces @p gradient, of the output, by the derivative by z, and adds that by the bias to @p byBias.
  void (*ComplexGeluBackward)(
    const float* z, const float* slopes, std::int64_t rows, std::int64_t width, float* gradient, float* byBias);

  /// Adds area (bx re + by im) and area (by re - bx im) to the complex rows of @p sums at the corners, (bx, by) the
  /// corner's basis gradient: the divergence of a complex map of z is a real map of these sums.
  void (*AddDivergence)(const float* z, const FaceRows& faces, std::int64_t width, float* sums);
  /// Transpose of AddDivergence(): sets z.
  void (*DivergenceTransposed)(const float* sums, const FaceRows& faces, std::int64_t width, float* z);

  /// Adds area / 3 (a_re b_re + a_im b_im) to the rows of @p sums at the corners, [points, width].
  void (*AddDots)(const float* a, const float* b, const FaceRows& faces, std::int64_t width, float* sums);
  /// Replaces a by the derivatives by it, and adds those by b to @p byB, from those by the sums.
  void (*DotsBackward)(
    const float* bySums, const float* b, const FaceRows& faces, std::int64_t width, float* a, float* byB);
};

/// Returns the kernels for CurrentInstructionSet().
const GradientKernels& BestGradientKernels();

// The variants: the same source compiled for different instruction sets.
extern const GradientKernels GenericGradientKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const GradientKernels Avx2GradientKernels;   ///< for AVX2
extern const GradientKernels Avx512GradientKernels; ///< for AVX-512
#endif

} // namespace surfsynth
