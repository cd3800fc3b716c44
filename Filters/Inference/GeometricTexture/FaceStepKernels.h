// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of convolutions over triangles [Hertz2020] beside the matrix products, with first and second derivatives.
/// Private to Inference and Learning.
///
/// Arrays are float32, row-major. Results of the variants differ in last bits only. A triangle looks at three rows of the
/// products, those of its neighbors or of its edges, and takes in each channel the largest, whose place among the three is
/// kept. n are normalized values, a = LeakyReLU(n) with slope 0.2, g the gradients by a, and h = g a' those by n.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// The triangles from @c First on, with the rows of products that they look at.
struct LookingFaces
{
  const std::int32_t* Rows; ///< [*, 3], of all triangles
  std::int64_t First;
  std::int64_t Count;
  std::int64_t Width; ///< channels
};

/// Rows of products from @c First on, with the triangles that look at them.
struct SeenRows
{
  const std::int32_t* Faces;  ///< [*, Uses], of all rows
  const std::uint8_t* Places; ///< [*, Uses], 0 to 2: which of the rows of that triangle it is
  std::int64_t Uses;          ///< 3 or 1
  std::int64_t First;
  std::int64_t Count;
  std::int64_t Width; ///< channels
};

/// A matrix whose rows are @c Stride numbers apart.
struct StridedRows
{
  const float* Data;
  std::int64_t Stride;
};

/// Coefficients of derivatives of the norm, [width] each: scale r, and means over all triangles.
struct NormMeans
{
  const float* Scale;
  const float* Gradient;         ///< of h
  const float* GradientTimes;    ///< of h n
  const float* Direction;        ///< of u
  const float* DirectionTimes;   ///< of u n
  const float* DirectionProduct; ///< of u h
};

/// Kernels for one instruction set. Arrays of the triangles begin with that of @c First; others are those of all rows.
struct FaceStepKernels
{
  /// out = bias + own + largest of three rows, and its place, the first of equal ones. @p own, rows of all triangles, may have
  /// no data.
  void (*Largest)(const LookingFaces& faces, const StridedRows& products, const StridedRows& own, const float* bias,
    float* out, std::uint8_t* places);
  /// out = own + the value at the kept place: the same linear map applied to others. @p own as above.
  void (*AtPlaces)(const LookingFaces& faces, const StridedRows& products, const StridedRows& own,
    const std::uint8_t* places, float* out);
  /// The transpose of AtPlaces(): out[row] = sum over the triangles that have taken it of their values. @p places and
  /// @p values are those of all triangles; rows of @p out are @p stride numbers apart.
  void (*SumAtPlaces)(
    const SeenRows& rows, const std::uint8_t* places, const StridedRows& values, float* out, std::int64_t stride);

  /// Adds h and h n to @p sums, [2, width].
  void (*AddGradientSums)(
    const float* gradients, const float* activated, std::int64_t rows, std::int64_t width, double* sums);
  /// out = r (h - mean h - n mean(h n)); rows of @p out are @p stride numbers apart.
  void (*NormGradient)(const float* gradients, const float* activated, const NormMeans& means, std::int64_t rows,
    std::int64_t width, float* out, std::int64_t stride);
  /// Adds u, u n and u h to @p sums, [3, width].
  void (*AddDirectionSums)(const float* directions, const float* gradients, const float* activated, std::int64_t rows,
    std::int64_t width, double* sums);
  /// Derivatives of the sum of u NormGradient(): by g, and by the values before the norm, @p values with rows @p stride
  /// numbers apart.
  void (*NormSecondGradient)(const float* directions, const float* gradients, const float* activated,
    const NormMeans& means, std::int64_t rows, std::int64_t width, float* byGradients, float* byValues,
    std::int64_t stride);
};

/// Returns the kernels for CurrentInstructionSet().
const FaceStepKernels& BestFaceStepKernels();

// The variants: the same source compiled for different instruction sets.
extern const FaceStepKernels GenericFaceStepKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const FaceStepKernels Avx2FaceStepKernels;   ///< for AVX2
extern const FaceStepKernels Avx512FaceStepKernels; ///< for AVX-512
#endif

} // namespace surfsynth
