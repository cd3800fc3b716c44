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

/// x (1 + erf(x / sqrt 2)) / 2 [Hendrycks2016], with erfc(z) = t (a1 + ... + a5 t^4) exp(-z^2), t = 1 / (1 + p z):
/// [Abramowitz1964], formula 7.1.26, error below 1.5e-7.
SURFSYNTH_INLINE float Gelu(float x)
{
  const float z = Smaller(__builtin_fabsf(x), 13.0F) * 0.707106781F;
  const float t = 1.0F / (1.0F + 0.3275911F * z);
  float series = 1.061405429F;
  series = series * t - 1.453152027F;
  series = series * t + 1.421413741F;
  series = series * t - 0.284496736F;
  series = series * t + 0.254829592F;
  const float complement = series * t * Exp(-z * z);
  return 0.5F * x * (x < 0.0F ? complement : 2.0F - complement);
}

/// log(1 + exp(x)) = max(x, 0) + log(1 + y) with y = exp(-|x|), and log(1 + y) = 2 artanh(y / (2 + y)) by its series to
/// s^15, s <= 1/3: accurate in relative terms also where it is tiny.
SURFSYNTH_INLINE float Softplus(float x)
{
  const float y = Exp(-__builtin_fabsf(x));
  const float s = y / (2.0F + y);
  const float z = s * s;
  float series = 1.0F / 15.0F;
  series = series * z + 1.0F / 13.0F;
  series = series * z + 1.0F / 11.0F;
  series = series * z + 1.0F / 9.0F;
  series = series * z + 1.0F / 7.0F;
  series = series * z + 1.0F / 5.0F;
  series = series * z + 1.0F / 3.0F;
  series = series * z + 1.0F;
  return Larger(x, 0.0F) + 2.0F * s * series;
}

SURFSYNTH_INLINE float Tanh(float x) { return 1.0F - 2.0F / (Exp(2.0F * x) + 1.0F); }

/// sin and cos of |x| < 1e5: minus the nearest multiple of pi / 2, in four parts so that products are exact, then
/// Taylor series to below 1e-8. Numbers without meaning for larger x; NaN for NaN.
SURFSYNTH_INLINE void SinCos(float x, float& sine, float& cosine)
{
  const float n = Nearest(x * 0.636619772F);
  float r = x - n * 1.5703125F;
  r -= n * 4.8351287841796875e-4F;
  r -= n * 3.13855707645416259766e-7F;
  r -= n * 6.0771005e-11F;
  const float z = r * r;
  float s = 1.0F / 362880.0F;
  s = s * z - 1.0F / 5040.0F;
  s = s * z + 1.0F / 120.0F;
  s = s * z - 1.0F / 6.0F;
  s = s * z * r + r;
  float c = 1.0F / 40320.0F;
  c = c * z - 1.0F / 720.0F;
  c = c * z + 1.0F / 24.0F;
  c = c * z - 0.5F;
  c = c * z + 1.0F;
  const std::int32_t quarter = static_cast<std::int32_t>(Larger(Smaller(n, 1e9F), -1e9F));
  const float first = (quarter & 1) != 0 ? c : s;
  const float second = (quarter & 1) != 0 ? s : c;
  sine = (quarter & 2) != 0 ? -first : first;
  cosine = ((quarter + 1) & 2) != 0 ? -second : second;
}

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
/// GELU(x) and its derivative Phi(x) + x phi(x), with Phi as in Gelu().
SURFSYNTH_INLINE void GeluAndDerivative(float x, float& value, float& derivative)
{
  const float magnitude = Smaller(__builtin_fabsf(x), 13.0F);
  const float z = magnitude * 0.707106781F;
  const float t = 1.0F / (1.0F + 0.3275911F * z);
  float series = 1.061405429F;
  series = series * t - 1.453152027F;
  series = series * t + 1.421413741F;
  series = series * t - 0.284496736F;
  series = series * t + 0.254829592F;
  const float bell = Exp(-z * z);
  const float complement = series * t * bell;
  const float probability = 0.5F * (x < 0.0F ? complement : 2.0F - complement);
  value = x * probability;
  derivative = probability + 0.398942280F * (x < 0.0F ? -magnitude : magnitude) * bell;
}

void ComplexGeluForward(const float* __restrict__ x, const float* __restrict__ y, const float* __restrict__ bias,
  Size rows, Size width, float* __restrict__ outX, float* __restrict__ outY)
{
  for (Size row = 0; row < rows; ++row, x += width, y += width, outX += width, outY += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      const float modulus = __builtin_sqrtf(x[c] * x[c] + y[c] * y[c] + 1e-8F);
      const float factor = Gelu(modulus + bias[c]) / (modulus + 1e-8F);
      outX[c] = x[c] * factor;
      outY[c] = y[c] * factor;
    }
  }
}

void ComplexGeluBackward(const float* __restrict__ x, const float* __restrict__ y, const float* __restrict__ bias,
  const float* __restrict__ gx, const float* __restrict__ gy, Size rows, Size width, float* __restrict__ dx,
  float* __restrict__ dy, float* __restrict__ dBias)
{
  for (Size row = 0; row < rows; ++row, x += width, y += width, gx += width, gy += width, dx += width, dy += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      const float modulus = __builtin_sqrtf(x[c] * x[c] + y[c] * y[c] + 1e-8F);
      const float inverse = 1.0F / (modulus + 1e-8F);
      float gelu;
      float slope;
      GeluAndDerivative(modulus + bias[c], gelu, slope);
      const float factor = gelu * inverse;
      const float dot = gx[c] * x[c] + gy[c] * y[c];
      const float byBias = dot * slope * inverse;
      const float along = (byBias - dot * factor * inverse) / modulus;
      dx[c] = gx[c] * factor + along * x[c];
      dy[c] = gy[c] * factor + along * y[c];
      dBias[c] += byBias;
    }
  }
}

void ModulateForward(const float* __restrict__ phaseAndScale, const float* __restrict__ x, const float* __restrict__ y,
  Size rows, Size width, float* __restrict__ outX, float* __restrict__ outY)
{
  for (Size row = 0; row < rows;
       ++row, phaseAndScale += 2 * width, x += width, y += width, outX += width, outY += width)
  {
    const float* __restrict__ scales = phaseAndScale + width;
    for (Size c = 0; c < width; ++c)
    {
      float sine;
      float cosine;
      SinCos(phaseAndScale[c], sine, cosine);
      const float scale = Softplus(scales[c]) + 1e-8F;
      outX[c] = (x[c] * cosine - y[c] * sine) * scale;
      outY[c] = (x[c] * sine + y[c] * cosine) * scale;
    }
  }
}

void ModulateBackward(const float* __restrict__ phaseAndScale, const float* __restrict__ x, const float* __restrict__ y,
  const float* __restrict__ gx, const float* __restrict__ gy, Size rows, Size width, float* __restrict__ dPhaseAndScale,
  float* __restrict__ dx, float* __restrict__ dy)
{
  for (Size row = 0; row < rows; ++row)
  {
    const float* __restrict__ scales = phaseAndScale + width;
    float* __restrict__ dScales = dPhaseAndScale + width;
    for (Size c = 0; c < width; ++c)
    {
      float sine;
      float cosine;
      SinCos(phaseAndScale[c], sine, cosine);
      const float scale = Softplus(scales[c]) + 1e-8F;
      const float turnedX = x[c] * cosine - y[c] * sine;
      const float turnedY = x[c] * sine + y[c] * cosine;
      dx[c] = (gx[c] * cosine + gy[c] * sine) * scale;
      dy[c] = (gy[c] * cosine - gx[c] * sine) * scale;
      dPhaseAndScale[c] = (gy[c] * turnedX - gx[c] * turnedY) * scale;
      // The slope of softplus is the logistic function.
      dScales[c] = (gx[c] * turnedX + gy[c] * turnedY) / (1.0F + Exp(-scales[c]));
    }
    phaseAndScale += 2 * width;
    dPhaseAndScale += 2 * width;
    x += width;
    y += width;
    gx += width;
    gy += width;
    dx += width;
    dy += width;
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
  ScatterDivergence, ScatterDots, ScaledTanh, ComplexGeluForward, ComplexGeluBackward, ModulateForward,
  ModulateBackward, GatherFaces, GatherVertices };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
