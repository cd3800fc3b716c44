// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the kernels of field latents, included once for each instruction set by a file that defines
/// SURFSYNTH_KERNELS (the table to define). Includes no standard header, as in ActivationKernelsImplementation.h.
#pragma once

#include "Inference/Common/ElementaryFunctions.h"
#include "Inference/FieldLatents/FieldLatentKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;

constexpr float NeuronDelta = 1e-3F;

SURFSYNTH_INLINE float Silu(float x) { return x / (1.0F + Exp(-x)); }

void Lift(const float* __restrict__ colors, const float* __restrict__ logarithms, const float* __restrict__ weights,
  const float* __restrict__ bias, Size rows, Size channels, float* __restrict__ out)
{
  const Size width = 2 * channels;
  for (Size row = 0; row < rows; ++row, colors += 3, logarithms += 2, out += width)
  {
    const float x = logarithms[0];
    const float y = logarithms[1];
    for (Size c = 0; c < channels; ++c)
    {
      const Size i = channels + c;
      const float re = bias[c] + colors[0] * weights[c] + colors[1] * weights[width + c] +
        colors[2] * weights[2 * width + c];
      const float im = bias[i] + colors[0] * weights[i] + colors[1] * weights[width + i] +
        colors[2] * weights[2 * width + i];
      out[c] = re * x - im * y;
      out[i] = re * y + im * x;
    }
  }
}

void Radii(const float* __restrict__ logarithms, const float* __restrict__ weights, const float* __restrict__ bias,
  Size rows, Size channels, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, logarithms += 2, out += channels)
  {
    const float radius = __builtin_sqrtf(logarithms[0] * logarithms[0] + logarithms[1] * logarithms[1]);
    for (Size c = 0; c < channels; ++c)
    {
      out[c] = Silu(radius * weights[c] + bias[c]);
    }
  }
}

void Gather(const float* __restrict__ colors, const float* __restrict__ logarithms, const float* __restrict__ weights,
  const float* __restrict__ bias, const float* __restrict__ filter, const float* __restrict__ filterBias, Size rows,
  Size channels, float* __restrict__ out)
{
  const Size width = 2 * channels;
  for (Size c = 0; c < width; ++c)
  {
    out[c] = 0.0F;
  }
  const float share = rows > 0 ? 1.0F / static_cast<float>(rows) : 0.0F;
  for (Size row = 0; row < rows; ++row, colors += 3, logarithms += 2, filter += width)
  {
    const float x = logarithms[0] * share;
    const float y = logarithms[1] * share;
    for (Size c = 0; c < channels; ++c)
    {
      const Size i = channels + c;
      const float re = bias[c] + colors[0] * weights[c] + colors[1] * weights[width + c] +
        colors[2] * weights[2 * width + c];
      const float im = bias[i] + colors[0] * weights[i] + colors[1] * weights[width + i] +
        colors[2] * weights[2 * width + i];
      const float real = re * x - im * y;
      const float imaginary = re * y + im * x;
      const float a = filter[c] + filterBias[c];
      const float b = filter[i] + filterBias[i];
      out[c] += real * a - imaginary * b;
      out[i] += real * b + imaginary * a;
    }
  }
}

void Normalize(const float* __restrict__ x, const float* __restrict__ a, const float* __restrict__ delta, Size rows,
  Size channels, float* __restrict__ scale, float* __restrict__ out)
{
  const Size width = 2 * channels;
  for (Size c = 0; c < channels; ++c)
  {
    scale[c] = 0.0F;
  }
  const float* __restrict__ in = x;
  for (Size row = 0; row < rows; ++row, in += width)
  {
    for (Size c = 0; c < channels; ++c)
    {
      scale[c] += in[c] * in[c] + in[channels + c] * in[channels + c];
    }
  }
  const float share = 1.0F / static_cast<float>(rows);
  for (Size c = 0; c < channels; ++c)
  {
    scale[c] = 1.0F / __builtin_sqrtf(scale[c] * share + delta[c]);
  }
  for (Size row = 0; row < rows; ++row, x += width, out += width)
  {
    for (Size c = 0; c < channels; ++c)
    {
      const float re = x[c] * scale[c];
      const float im = x[channels + c] * scale[c];
      out[c] = re * a[c] - im * a[channels + c];
      out[channels + c] = re * a[channels + c] + im * a[c];
    }
  }
}

void NormalizeGradient(const float* __restrict__ x, const float* __restrict__ a, const float* __restrict__ scale,
  const float* __restrict__ gradient, Size rows, Size channels, float* __restrict__ scratch, float* __restrict__ dx,
  float* __restrict__ da, float* __restrict__ dDelta)
{
  const Size width = 2 * channels;
  for (Size c = 0; c < channels; ++c)
  {
    scratch[c] = 0.0F; // the derivative by the scale
  }
  for (Size row = 0; row < rows; ++row)
  {
    const float* __restrict__ in = x + row * width;
    const float* __restrict__ g = gradient + row * width;
    for (Size c = 0; c < channels; ++c)
    {
      // conj(x) g: the derivative by a, over the scale.
      const float re = in[c] * g[c] + in[channels + c] * g[channels + c];
      const float im = in[c] * g[channels + c] - in[channels + c] * g[c];
      da[c] += re * scale[c];
      da[channels + c] += im * scale[c];
      scratch[c] += re * a[c] + im * a[channels + c];
    }
  }
  const float share = 1.0F / static_cast<float>(rows);
  for (Size c = 0; c < channels; ++c)
  {
    const float bySquare = -0.5F * scale[c] * scale[c] * scale[c] * scratch[c];
    dDelta[c] += bySquare;
    scratch[c] = 2.0F * share * bySquare;
  }
  for (Size row = 0; row < rows; ++row, x += width, gradient += width, dx += width)
  {
    for (Size c = 0; c < channels; ++c)
    {
      const float re = gradient[c] * scale[c];
      const float im = gradient[channels + c] * scale[c];
      dx[c] = re * a[c] + im * a[channels + c] + scratch[c] * x[c];
      dx[channels + c] = im * a[c] - re * a[channels + c] + scratch[c] * x[channels + c];
    }
  }
}

SURFSYNTH_INLINE void NeuronOf(float kr, float ki, float qr, float qi, float& re, float& im)
{
  const float t = Larger(-(qr * kr + qi * ki), 0.0F) / (kr * kr + ki * ki + NeuronDelta);
  re = qr + t * kr;
  im = qi + t * ki;
}

void Neuron(const float* __restrict__ in, Size rows, Size channels, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, in += 4 * channels, out += 2 * channels)
  {
    for (Size c = 0; c < channels; ++c)
    {
      float re;
      float im;
      NeuronOf(in[c], in[channels + c], in[2 * channels + c], in[3 * channels + c], re, im);
      out[c] = re;
      out[channels + c] = im;
    }
  }
}

void AddNeuron(const float* __restrict__ in, Size rows, Size channels, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, in += 4 * channels, out += 2 * channels)
  {
    for (Size c = 0; c < channels; ++c)
    {
      float re;
      float im;
      NeuronOf(in[c], in[channels + c], in[2 * channels + c], in[3 * channels + c], re, im);
      out[c] += re;
      out[channels + c] += im;
    }
  }
}

void NeuronGradient(
  const float* __restrict__ in, const float* __restrict__ gradient, Size rows, Size channels, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, in += 4 * channels, gradient += 2 * channels, out += 4 * channels)
  {
    for (Size c = 0; c < channels; ++c)
    {
      const float kr = in[c];
      const float ki = in[channels + c];
      const float qr = in[2 * channels + c];
      const float qi = in[3 * channels + c];
      const float gr = gradient[c];
      const float gi = gradient[channels + c];
      const float against = -(qr * kr + qi * ki);
      const float inverse = 1.0F / (kr * kr + ki * ki + NeuronDelta);
      const float t = Larger(against, 0.0F) * inverse;
      // The derivative by t, over the denominator; 0 where the ReLU is.
      const float byT = against > 0.0F ? (gr * kr + gi * ki) * inverse : 0.0F;
      out[c] = t * gr - byT * (qr + 2.0F * t * kr);
      out[channels + c] = t * gi - byT * (qi + 2.0F * t * ki);
      out[2 * channels + c] = gr - byT * kr;
      out[3 * channels + c] = gi - byT * ki;
    }
  }
}

void ColumnSoftmax(float* __restrict__ values, float scale, Size rows, Size columns, float* __restrict__ scratch)
{
  float* __restrict__ largest = scratch;
  float* __restrict__ sum = scratch + columns;
  for (Size c = 0; c < columns; ++c)
  {
    largest[c] = values[c];
    sum[c] = 0.0F;
  }
  for (Size row = 1; row < rows; ++row)
  {
    for (Size c = 0; c < columns; ++c)
    {
      largest[c] = Larger(largest[c], values[row * columns + c]);
    }
  }
  for (Size row = 0; row < rows; ++row)
  {
    float* __restrict__ at = values + row * columns;
    for (Size c = 0; c < columns; ++c)
    {
      at[c] = Exp(scale * (at[c] - largest[c]));
      sum[c] += at[c];
    }
  }
  for (Size c = 0; c < columns; ++c)
  {
    sum[c] = 1.0F / sum[c];
  }
  for (Size row = 0; row < rows; ++row)
  {
    float* __restrict__ at = values + row * columns;
    for (Size c = 0; c < columns; ++c)
    {
      at[c] *= sum[c];
    }
  }
}

void ColumnSoftmaxGradient(const float* __restrict__ probabilities, float scale, Size rows, Size columns,
  float* __restrict__ scratch, float* __restrict__ gradient)
{
  for (Size c = 0; c < columns; ++c)
  {
    scratch[c] = 0.0F;
  }
  for (Size row = 0; row < rows; ++row)
  {
    for (Size c = 0; c < columns; ++c)
    {
      scratch[c] += probabilities[row * columns + c] * gradient[row * columns + c];
    }
  }
  for (Size row = 0; row < rows; ++row)
  {
    for (Size c = 0; c < columns; ++c)
    {
      float& value = gradient[row * columns + c];
      value = scale * probabilities[row * columns + c] * (value - scratch[c]);
    }
  }
}

void BiasSilu(float* __restrict__ values, const float* __restrict__ bias, Size rows, Size width)
{
  for (Size row = 0; row < rows; ++row, values += width)
  {
    for (Size c = 0; c < width; ++c)
    {
      values[c] = Silu(values[c] + bias[c]);
    }
  }
}

void LogarithmicTexels(
  const float* shares, const std::int32_t* ids, const float* logarithms, Size rows, Size width, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, out += width)
  {
    const float* __restrict__ share = shares + ids[row] * 3 * width;
    const float x = logarithms[2 * row];
    const float y = logarithms[2 * row + 1];
    for (Size c = 0; c < width; ++c)
    {
      out[c] = Silu(share[c] + x * share[width + c] + y * share[2 * width + c]);
    }
  }
}

void BarycentricTexels(const float* shares, const std::int32_t* ids, const float* barycentric,
  const float* __restrict__ bias, Size rows, Size width, float* __restrict__ out)
{
  for (Size row = 0; row < rows; ++row, ids += 3, barycentric += 3, out += width)
  {
    const float* __restrict__ a = shares + ids[0] * width;
    const float* __restrict__ b = shares + ids[1] * width;
    const float* __restrict__ d = shares + ids[2] * width;
    for (Size c = 0; c < width; ++c)
    {
      out[c] = Silu(bias[c] + barycentric[0] * a[c] + barycentric[1] * b[c] + barycentric[2] * d[c]);
    }
  }
}
} // namespace

extern const FieldLatentKernels SURFSYNTH_KERNELS = { Lift, Radii, Gather, Normalize, NormalizeGradient, Neuron,
  AddNeuron, NeuronGradient, ColumnSoftmax, ColumnSoftmaxGradient, BiasSilu, LogarithmicTexels, BarycentricTexels };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
