// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the gradient kernels, included once for each instruction set by a file that defines SURFSYNTH_KERNELS (the
/// table to define). See ActivationKernelsImplementation.h for its rules.
#pragma once

#include "Inference/Common/ElementaryFunctions.h"
#include "Inference/PoissonNet/GradientKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;

void FillRows(const float* __restrict__ row, Size rows, Size width, float* __restrict__ out)
{
  for (Size k = 0; k < rows; ++k, out += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      out[c] = row[c];
    }
  }
}

void AddColumnSums(const float* __restrict__ values, Size rows, Size width, float* __restrict__ sums)
{
  for (Size k = 0; k < rows; ++k, values += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      sums[c] += values[c];
    }
  }
}

void GeluOf(const float* __restrict__ in, Size count, float* __restrict__ out)
{
  for (Size k = 0; k < count; ++k)
  {
    out[k] = Gelu(in[k]);
  }
}

void GeluWithSlopes(const float* in, Size count, float* __restrict__ out, float* slopes)
{
#ifndef __clang__ // which takes no such hint
#pragma GCC ivdep
#endif
  for (Size k = 0; k < count; ++k)
  {
    float value;
    float slope;
    GeluAndDerivative(in[k], value, slope);
    out[k] = value;
    slopes[k] = slope;
  }
}

void Scale(const float* __restrict__ factors, Size count, float* __restrict__ values)
{
  for (Size k = 0; k < count; ++k)
  {
    values[k] *= factors[k];
  }
}

void AddScaled(
  const float* __restrict__ terms, const float* __restrict__ scale, Size rows, Size width, float* __restrict__ values)
{
  for (Size k = 0; k < rows; ++k, terms += width, values += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      values[c] += scale[c] * terms[c];
    }
  }
}

void AddScaledBackward(const float* __restrict__ gradient, const float* __restrict__ terms,
  const float* __restrict__ scale, Size rows, Size width, float* __restrict__ byTerms, float* __restrict__ byScale)
{
  for (Size k = 0; k < rows; ++k, gradient += width, terms += width, byTerms += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      byTerms[c] = scale[c] * gradient[c];
      byScale[c] += gradient[c] * terms[c];
    }
  }
}

void Gradient(const float* __restrict__ signal, const FaceRows& faces, Size width, float* __restrict__ z)
{
  for (Size row = 0; row < faces.Rows; ++row, z += 2 * width)
  {
    const std::int32_t* corners = faces.Corners + 3 * row;
    const float* g = faces.BasisGradients + 6 * row;
    const float g0 = g[0];
    const float g1 = g[1];
    const float g2 = g[2];
    const float g3 = g[3];
    const float g4 = g[4];
    const float g5 = g[5];
    const float* __restrict__ a = signal + corners[0] * width;
    const float* __restrict__ b = signal + corners[1] * width;
    const float* __restrict__ c = signal + corners[2] * width;
    float* __restrict__ im = z + width;
    for (Size k = 0; k < width; ++k)
    {
      z[k] = g0 * a[k] + g1 * b[k] + g2 * c[k];
      im[k] = g3 * a[k] + g4 * b[k] + g5 * c[k];
    }
  }
}

void CornerMean(const float* __restrict__ signal, const FaceRows& faces, Size width, float* __restrict__ mean)
{
  for (Size row = 0; row < faces.Rows; ++row, mean += width)
  {
    const std::int32_t* corners = faces.Corners + 3 * row;
    const float* __restrict__ a = signal + corners[0] * width;
    const float* __restrict__ b = signal + corners[1] * width;
    const float* __restrict__ c = signal + corners[2] * width;
    for (Size k = 0; k < width; ++k)
    {
      mean[k] = (a[k] + b[k] + c[k]) * (1.0F / 3.0F);
    }
  }
}

void AddTransposed(
  const float* __restrict__ z, const float* __restrict__ mean, const FaceRows& faces, Size width, float* sums)
{
  const Size stride = mean != nullptr ? 2 * width : width;
  for (Size row = 0; row < faces.Rows; ++row, z += 2 * width)
  {
    const float* __restrict__ im = z + width;
    for (int corner = 0; corner < 3; ++corner)
    {
      const float x = faces.BasisGradients[6 * row + corner];
      const float y = faces.BasisGradients[6 * row + 3 + corner];
      float* __restrict__ to = sums + faces.Corners[3 * row + corner] * stride;
      for (Size k = 0; k < width; ++k)
      {
        to[k] += x * z[k] + y * im[k];
      }
      if (mean != nullptr)
      {
        const float* __restrict__ from = mean + row * width;
        float* __restrict__ other = to + width;
        for (Size k = 0; k < width; ++k)
        {
          other[k] += from[k] * (1.0F / 3.0F);
        }
      }
    }
  }
}

// Real and imaginary parts of a row are arguments of their own: the compiler then knows that they do not overlap.

SURFSYNTH_INLINE void ModulateRow(const float* __restrict__ phases, const float* __restrict__ scales,
  const float* __restrict__ x, const float* __restrict__ y, Size width, float* __restrict__ outX,
  float* __restrict__ outY)
{
  for (Size c = 0; c < width; ++c)
  {
    float sine;
    float cosine;
    SinCos(phases[c], sine, cosine);
    const float scale = Softplus(scales[c]) + 1e-8F;
    outX[c] = (x[c] * cosine - y[c] * sine) * scale;
    outY[c] = (x[c] * sine + y[c] * cosine) * scale;
  }
}

void Modulate(const float* phaseAndScale, const float* z, Size rows, Size width, float* out)
{
  for (Size row = 0; row < rows; ++row, phaseAndScale += 2 * width, z += 2 * width, out += 2 * width)
  {
    ModulateRow(phaseAndScale, phaseAndScale + width, z, z + width, width, out, out + width);
  }
}

SURFSYNTH_INLINE void ModulateWithSlopesRow(const float* __restrict__ x, const float* __restrict__ y, Size width,
  float* __restrict__ phases, float* __restrict__ scales, float* __restrict__ outX, float* __restrict__ outY,
  float* __restrict__ slopes)
{
  for (Size c = 0; c < width; ++c)
  {
    float sine;
    float cosine;
    SinCos(phases[c], sine, cosine);
    const float scale = Softplus(scales[c]) + 1e-8F;
    // The slope of softplus is the logistic function.
    slopes[c] = 1.0F / ((1.0F + Exp(-scales[c])) * scale);
    const float re = cosine * scale;
    const float im = sine * scale;
    phases[c] = re;
    scales[c] = im;
    outX[c] = x[c] * re - y[c] * im;
    outY[c] = x[c] * im + y[c] * re;
  }
}

void ModulateWithSlopes(float* phaseAndScale, const float* z, Size rows, Size width, float* out, float* slopes)
{
  for (Size row = 0; row < rows; ++row, phaseAndScale += 2 * width, z += 2 * width, out += 2 * width, slopes += width)
  {
    ModulateWithSlopesRow(z, z + width, width, phaseAndScale, phaseAndScale + width, out, out + width, slopes);
  }
}

SURFSYNTH_INLINE void ModulateBackwardRow(const float* __restrict__ outX, const float* __restrict__ outY,
  const float* __restrict__ slopes, Size width, float* __restrict__ re, float* __restrict__ im, float* __restrict__ byX,
  float* __restrict__ byY)
{
  for (Size c = 0; c < width; ++c)
  {
    const float gx = byX[c];
    const float gy = byY[c];
    byX[c] = gx * re[c] + gy * im[c];
    byY[c] = gy * re[c] - gx * im[c];
    re[c] = gy * outX[c] - gx * outY[c];
    im[c] = (gx * outX[c] + gy * outY[c]) * slopes[c];
  }
}

void ModulateBackward(const float* out, const float* slopes, Size rows, Size width, float* factors, float* gradient)
{
  for (Size row = 0; row < rows; ++row, out += 2 * width, slopes += width, factors += 2 * width, gradient += 2 * width)
  {
    ModulateBackwardRow(out, out + width, slopes, width, factors, factors + width, gradient, gradient + width);
  }
}

SURFSYNTH_INLINE void ComplexGeluRow(const float* __restrict__ x, const float* __restrict__ y,
  const float* __restrict__ bias, Size width, float* __restrict__ outX, float* __restrict__ outY)
{
  for (Size c = 0; c < width; ++c)
  {
    const float modulus = __builtin_sqrtf(x[c] * x[c] + y[c] * y[c] + 1e-8F);
    const float factor = Gelu(modulus + bias[c]) / (modulus + 1e-8F);
    outX[c] = x[c] * factor;
    outY[c] = y[c] * factor;
  }
}

void ComplexGelu(const float* z, const float* bias, Size rows, Size width, float* out)
{
  for (Size row = 0; row < rows; ++row, z += 2 * width, out += 2 * width)
  {
    ComplexGeluRow(z, z + width, bias, width, out, out + width);
  }
}

SURFSYNTH_INLINE void ComplexGeluWithSlopesRow(const float* __restrict__ x, const float* __restrict__ y,
  const float* __restrict__ bias, Size width, float* __restrict__ outX, float* __restrict__ outY,
  float* __restrict__ factors, float* __restrict__ byBias, float* __restrict__ byModulus)
{
  for (Size c = 0; c < width; ++c)
  {
    const float modulus = __builtin_sqrtf(x[c] * x[c] + y[c] * y[c] + 1e-8F);
    const float inverse = 1.0F / (modulus + 1e-8F);
    float gelu;
    float slope;
    GeluAndDerivative(modulus + bias[c], gelu, slope);
    const float factor = gelu * inverse;
    outX[c] = x[c] * factor;
    outY[c] = y[c] * factor;
    factors[c] = factor;
    byBias[c] = slope * inverse;
    byModulus[c] = (slope - factor) * inverse * inverse;
  }
}

void ComplexGeluWithSlopes(const float* z, const float* bias, Size rows, Size width, float* out, float* slopes)
{
  for (Size row = 0; row < rows; ++row, z += 2 * width, out += 2 * width, slopes += 3 * width)
  {
    ComplexGeluWithSlopesRow(z, z + width, bias, width, out, out + width, slopes, slopes + width, slopes + 2 * width);
  }
}

SURFSYNTH_INLINE void ComplexGeluBackwardRow(const float* __restrict__ x, const float* __restrict__ y,
  const float* __restrict__ slopes, Size width, float* __restrict__ byX, float* __restrict__ byY,
  float* __restrict__ byBias)
{
  for (Size c = 0; c < width; ++c)
  {
    const float dot = byX[c] * x[c] + byY[c] * y[c];
    const float along = dot * slopes[2 * width + c];
    byX[c] = byX[c] * slopes[c] + along * x[c];
    byY[c] = byY[c] * slopes[c] + along * y[c];
    byBias[c] += dot * slopes[width + c];
  }
}

void ComplexGeluBackward(const float* z, const float* slopes, Size rows, Size width, float* gradient, float* byBias)
{
  for (Size row = 0; row < rows; ++row, z += 2 * width, slopes += 3 * width, gradient += 2 * width)
  {
    ComplexGeluBackwardRow(z, z + width, slopes, width, gradient, gradient + width, byBias);
  }
}

void AddDivergence(const float* __restrict__ z, const FaceRows& faces, Size width, float* sums)
{
  for (Size row = 0; row < faces.Rows; ++row, z += 2 * width)
  {
    const float* __restrict__ im = z + width;
    for (int corner = 0; corner < 3; ++corner)
    {
      const float x = faces.Areas[row] * faces.BasisGradients[6 * row + corner];
      const float y = faces.Areas[row] * faces.BasisGradients[6 * row + 3 + corner];
      float* __restrict__ along = sums + faces.Corners[3 * row + corner] * 2 * width;
      float* __restrict__ across = along + width;
      for (Size k = 0; k < width; ++k)
      {
        along[k] += x * z[k] + y * im[k];
        across[k] += y * z[k] - x * im[k];
      }
    }
  }
}

void DivergenceTransposed(const float* sums, const FaceRows& faces, Size width, float* __restrict__ z)
{
  for (Size row = 0; row < faces.Rows; ++row, z += 2 * width)
  {
    const std::int32_t* corners = faces.Corners + 3 * row;
    const float* g = faces.BasisGradients + 6 * row;
    const float area = faces.Areas[row];
    const float x0 = area * g[0];
    const float x1 = area * g[1];
    const float x2 = area * g[2];
    const float y0 = area * g[3];
    const float y1 = area * g[4];
    const float y2 = area * g[5];
    const float* __restrict__ a = sums + corners[0] * 2 * width;
    const float* __restrict__ b = sums + corners[1] * 2 * width;
    const float* __restrict__ c = sums + corners[2] * 2 * width;
    float* __restrict__ im = z + width;
    for (Size k = 0; k < width; ++k)
    {
      z[k] = (x0 * a[k] + x1 * b[k] + x2 * c[k]) + (y0 * a[width + k] + y1 * b[width + k] + y2 * c[width + k]);
      im[k] = (y0 * a[k] + y1 * b[k] + y2 * c[k]) - (x0 * a[width + k] + x1 * b[width + k] + x2 * c[width + k]);
    }
  }
}

void AddDots(const float* __restrict__ a, const float* __restrict__ b, const FaceRows& faces, Size width, float* sums)
{
  for (Size row = 0; row < faces.Rows; ++row, a += 2 * width, b += 2 * width)
  {
    const float weight = faces.Areas[row] * (1.0F / 3.0F);
    for (int corner = 0; corner < 3; ++corner)
    {
      float* __restrict__ to = sums + faces.Corners[3 * row + corner] * width;
      for (Size k = 0; k < width; ++k)
      {
        to[k] += weight * (a[k] * b[k] + a[width + k] * b[width + k]);
      }
    }
  }
}

void DotsBackward(const float* bySums, const float* __restrict__ b, const FaceRows& faces, Size width,
  float* __restrict__ a, float* __restrict__ byB)
{
  for (Size row = 0; row < faces.Rows; ++row, a += 2 * width, b += 2 * width, byB += 2 * width)
  {
    const float weight = faces.Areas[row] * (1.0F / 3.0F);
    const float* __restrict__ first = bySums + faces.Corners[3 * row] * width;
    const float* __restrict__ second = bySums + faces.Corners[3 * row + 1] * width;
    const float* __restrict__ third = bySums + faces.Corners[3 * row + 2] * width;
    for (Size k = 0; k < width; ++k)
    {
      const float g = weight * (first[k] + second[k] + third[k]);
      byB[k] += g * a[k];
      byB[width + k] += g * a[width + k];
      a[k] = g * b[k];
      a[width + k] = g * b[width + k];
    }
  }
}
} // namespace

extern const GradientKernels SURFSYNTH_KERNELS = { FillRows, AddColumnSums, GeluOf, GeluWithSlopes, Scale, AddScaled,
  AddScaledBackward, Gradient, CornerMean, AddTransposed, Modulate, ModulateWithSlopes, ModulateBackward, ComplexGelu,
  ComplexGeluWithSlopes, ComplexGeluBackward, AddDivergence, DivergenceTransposed, AddDots, DotsBackward };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
