// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the face kernels, included once for each instruction set by a file that defines SURFSYNTH_KERNELS (the
/// table to define). Includes no standard header, as in ActivationKernelsImplementation.h.
#pragma once

#include "Inference/GeometricTexture/FaceKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;

constexpr float Slope = 0.2F; // of LeakyReLU below 0

inline float Larger(float a, float b) { return a > b ? a : b; }

inline float EdgeMap(const float* edge, const float* matrix, Size width, Size c)
{
  return edge[0] * matrix[c] + edge[1] * matrix[width + c] + edge[2] * matrix[2 * width + c] +
    edge[3] * matrix[3 * width + c];
}

void EdgeMaps(const float* __restrict__ features, const float* __restrict__ matrix, const float* __restrict__ bias,
  Size rows, Size width, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, features += 12, out += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      out[c] = bias[c] +
        Larger(EdgeMap(features, matrix, width, c),
          Larger(EdgeMap(features + 4, matrix, width, c), EdgeMap(features + 8, matrix, width, c)));
    }
  }
}

void AddLargest(const float* __restrict__ a, const float* __restrict__ b, const float* __restrict__ c,
  const float* __restrict__ bias, Size width, float* __restrict__ own)
{
  for (Size k = 0; k < width; ++k)
  {
    own[k] += bias[k] + Larger(a[k], Larger(b[k], c[k]));
  }
}

void GatherMax(const std::int32_t* neighbors, const float* bias, Size first, Size rows, Size width, float* products)
{
  for (Size row = first; row < first + rows; ++row)
  {
    const std::int32_t* beside = neighbors + 3 * row;
    const Size stride = 2 * width;
    AddLargest(products + beside[0] * stride + width, products + beside[1] * stride + width,
      products + beside[2] * stride + width, bias, width, products + row * stride);
  }
}

void AddMoments(const float* __restrict__ values, Size stride, Size rows, Size width, double* __restrict__ sums,
  double* __restrict__ squares)
{
  for (Size row = 0; row < rows; ++row, values += stride)
  {
    for (Size c = 0; c < width; ++c)
    {
      const double value = values[c];
      sums[c] += value;
      squares[c] += value * value;
    }
  }
}

void Normalize(const float* values, Size stride, const float* __restrict__ mean, const float* __restrict__ scale,
  Size rows, Size width, float* out)
{
  for (Size row = 0; row < rows; ++row, values += stride, out += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      const float value = (values[c] - mean[c]) * scale[c];
      out[c] = Larger(value, Slope * value);
    }
  }
}
} // namespace

extern const FaceKernels SURFSYNTH_KERNELS = { EdgeMaps, GatherMax, AddMoments, Normalize };

} // namespace surfsynth
