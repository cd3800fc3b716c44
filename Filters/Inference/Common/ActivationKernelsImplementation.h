// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the activation kernels, included once for each instruction set by a file that defines SURFSYNTH_KERNELS
/// (the table to define).
///
/// Loops are plain and without branches, so that compilers turn them into vector code. The functions that they call
/// must be inlined for that, however many loops call them. Includes no standard header: its inline functions would be
/// compiled for the wide instruction set too, and the linker might keep that copy for everybody.
#pragma once

#include "Inference/Common/ActivationKernels.h"
#include "Inference/Common/ElementaryFunctions.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;
using Id = std::int32_t;

void BiasGelu(float* __restrict__ values, const float* __restrict__ bias, Size rows, Size width)
{
  for (Size row = 0; row < rows; ++row, values += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      values[c] = Gelu(values[c] + bias[c]);
    }
  }
}

void Modulate(const float* __restrict__ phaseAndScale, const float* __restrict__ bias, Size rows, Size width,
  float* __restrict__ re, float* __restrict__ im, float* __restrict__ sum)
{
  for (Size row = 0; row < rows; ++row, phaseAndScale += 2 * width, re += width, im += width, sum += width)
  {
    const float* __restrict__ scales = phaseAndScale + width;
    for (Size c = 0; c < width; ++c)
    {
      float sine;
      float cosine;
      SinCos(phaseAndScale[c] + bias[c], sine, cosine);
      const float scale = Softplus(scales[c] + bias[width + c]) + 1e-8F;
      const float x = re[c];
      const float y = im[c];
      const float a = (x * cosine - y * sine) * scale;
      const float b = (x * sine + y * cosine) * scale;
      re[c] = a;
      im[c] = b;
      sum[c] = a + b;
    }
  }
}

void ComplexGelu(const float* __restrict__ p1, const float* __restrict__ p2, const float* __restrict__ p3,
  const float* __restrict__ bias, Size rows, Size width, float* __restrict__ re, float* __restrict__ im,
  float* __restrict__ sum)
{
  for (Size row = 0; row < rows; ++row)
  {
    for (Size c = 0; c < width; ++c)
    {
      const float x = p1[c] - p3[c];
      const float y = p1[c] + p2[c];
      const float modulus = __builtin_sqrtf(x * x + y * y + 1e-8F);
      const float factor = Gelu(modulus + bias[c]) / (modulus + 1e-8F);
      re[c] = x * factor;
      im[c] = y * factor;
      sum[c] = (x + y) * factor;
    }
    p1 += width;
    p2 += width;
    p3 += width;
    re += width;
    im += width;
    sum += width;
  }
}

void FaceGradient(const float* __restrict__ signal, const Id* __restrict__ corners,
  const float* __restrict__ basisGradients, Size rows, Size width, float* __restrict__ re, float* __restrict__ im)
{
  for (Size row = 0; row < rows; ++row, corners += 3, basisGradients += 6, re += width, im += width)
  {
    const float* __restrict__ a = signal + corners[0] * width;
    const float* __restrict__ b = signal + corners[1] * width;
    const float* __restrict__ c = signal + corners[2] * width;
    for (Size k = 0; k < width; ++k)
    {
      re[k] = basisGradients[0] * a[k] + basisGradients[1] * b[k] + basisGradients[2] * c[k];
      im[k] = basisGradients[3] * a[k] + basisGradients[4] * b[k] + basisGradients[5] * c[k];
    }
  }
}

void FaceMeanGelu(
  const float* __restrict__ signal, const Id* __restrict__ corners, Size rows, Size width, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, corners += 3, out += width)
  {
    const float* __restrict__ a = signal + corners[0] * width;
    const float* __restrict__ b = signal + corners[1] * width;
    const float* __restrict__ c = signal + corners[2] * width;
    for (Size k = 0; k < width; ++k)
    {
      out[k] = Gelu((a[k] + b[k] + c[k]) * (1.0F / 3.0F));
    }
  }
}

void ScatterDivergence(const float* __restrict__ re, const float* __restrict__ im, const Id* __restrict__ corners,
  const float* __restrict__ basisGradients, const float* __restrict__ areas, Size rows, Size width, float* along,
  float* across)
{
  for (Size row = 0; row < rows; ++row, corners += 3, basisGradients += 6, re += width, im += width)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      const float x = areas[row] * basisGradients[corner];
      const float y = areas[row] * basisGradients[3 + corner];
      float* __restrict__ to = along + corners[corner] * width;
      float* __restrict__ other = across + corners[corner] * width;
      for (Size k = 0; k < width; ++k)
      {
        to[k] += x * re[k] + y * im[k];
        other[k] += y * re[k] - x * im[k];
      }
    }
  }
}

void ScatterDots(const float* __restrict__ p1, const float* __restrict__ p2, const float* __restrict__ p3,
  const float* __restrict__ re, const float* __restrict__ im, const Id* __restrict__ corners,
  const float* __restrict__ areas, Size rows, Size width, float* sums)
{
  for (Size row = 0; row < rows; ++row, corners += 3)
  {
    const float weight = areas[row] * (1.0F / 3.0F);
    float* a = sums + corners[0] * width;
    float* b = sums + corners[1] * width;
    float* c = sums + corners[2] * width;
    for (Size k = row * width; k < (row + 1) * width; ++k)
    {
      const float dot = weight * ((p1[k] - p3[k]) * re[k] + (p1[k] + p2[k]) * im[k]);
      a[k - row * width] += dot;
      b[k - row * width] += dot;
      c[k - row * width] += dot;
    }
  }
}

void ScaledTanh(float* __restrict__ values, const float* __restrict__ scale, Size rows, Size width)
{
  for (Size row = 0; row < rows; ++row, values += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      values[c] = Tanh(values[c] * scale[c]);
    }
  }
}
void GatherFaces(const float* __restrict__ signal, const Id* __restrict__ corners,
  const float* __restrict__ basisGradients, Size rows, Size width, float* __restrict__ re, float* __restrict__ im,
  float* __restrict__ mean)
{
  for (Size row = 0; row < rows; ++row, corners += 3, basisGradients += 6, re += width, im += width, mean += width)
  {
    const float* __restrict__ a = signal + corners[0] * width;
    const float* __restrict__ b = signal + corners[1] * width;
    const float* __restrict__ c = signal + corners[2] * width;
    for (Size k = 0; k < width; ++k)
    {
      re[k] = basisGradients[0] * a[k] + basisGradients[1] * b[k] + basisGradients[2] * c[k];
      im[k] = basisGradients[3] * a[k] + basisGradients[4] * b[k] + basisGradients[5] * c[k];
      mean[k] = (a[k] + b[k] + c[k]) * (1.0F / 3.0F);
    }
  }
}

SURFSYNTH_INLINE void AddRow(float* __restrict__ out, const float* __restrict__ row, float weight, Size width)
{
  for (Size k = 0; k < width; ++k)
  {
    out[k] += weight * row[k];
  }
}

void GatherVertices(const float* re, const float* im, const float* mean, const Id* offsets, const Id* faces,
  const float* wx, const float* wy, const float* wm, Size first, Size rows, Size width, float* out)
{
  for (Size v = first; v < first + rows; ++v)
  {
    float* __restrict__ row = out + v * width;
    for (Size k = 0; k < width; ++k)
    {
      row[k] = 0.0F;
    }
    for (Id e = offsets[v]; e < offsets[v + 1]; ++e)
    {
      const Size from = faces[e] * width;
      if (re != nullptr)
      {
        AddRow(row, re + from, wx[e], width);
        AddRow(row, im + from, wy[e], width);
      }
      if (mean != nullptr)
      {
        AddRow(row, mean + from, wm[e], width);
      }
    }
  }
}
} // namespace

extern const ActivationKernels SURFSYNTH_KERNELS = { BiasGelu, Modulate, ComplexGelu, FaceGradient, FaceMeanGelu,
  ScatterDivergence, ScatterDots, ScaledTanh, GatherFaces, GatherVertices };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
