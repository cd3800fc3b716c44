// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Loops of LatentDiffusionKernels.h. Each source that includes this names its variant in SURFSYNTH_KERNELS. Private to
/// the inference; includes no standard header but <cstdint>: see ActivationKernelsImplementation.h.
#pragma once

#include "Inference/Common/ElementaryFunctions.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;
constexpr int K = static_cast<int>(FilterChannels);
/// Channels side by side: those of a register.
#if defined(__AVX512F__)
constexpr int Lanes = 16;
#elif defined(__AVX__)
constexpr int Lanes = 8;
#else
constexpr int Lanes = 4;
#endif
using Vector = float __attribute__((vector_size(4 * Lanes)));

SURFSYNTH_INLINE Vector Load(const float* from, Size count)
{
  Vector value = {};
  if (count >= Lanes)
  {
    __builtin_memcpy(&value, from, sizeof(value));
  }
  else
  {
    __builtin_memcpy(&value, from, static_cast<decltype(sizeof(float))>(4 * count));
  }
  return value;
}

SURFSYNTH_INLINE void Store(const Vector& value, float* to, Size count)
{
  if (count >= Lanes)
  {
    __builtin_memcpy(to, &value, sizeof(value));
  }
  else
  {
    __builtin_memcpy(to, &value, static_cast<decltype(sizeof(float))>(4 * count));
  }
}

SURFSYNTH_INLINE Vector Relu(const Vector& value) { return value > 0.0F ? value : Vector{}; }

/// Numbers of one edge that all channels share.
struct EdgeNumbers
{
  float Constant[K]; ///< share, bias and radius in the first layer
  float ByReal[K];   ///< factors of the real part of the unit feature at the source, in the frame of the source
  float ByImaginary[K];
  float Re; ///< weight times transport
  float Im;
};

SURFSYNTH_INLINE void Prepare(const FieldNeighborhoods& at, const FieldFilter& filter, std::int32_t e, EdgeNumbers& out)
{
  const std::int32_t q = at.Sources[e];
  const float x = at.Logarithms[2 * e];
  const float y = at.Logarithms[2 * e + 1];
  const float tr = at.Transport[2 * e];
  const float ti = at.Transport[2 * e + 1];
  const float radius = __builtin_sqrtf(x * x + y * y);
  const float inverse = radius > 0.0F ? 1.0F / radius : 0.0F;
  // The logarithm's direction in the frame of the source: conj(t u) l = conj(u) (conj(t) l).
  const float lx = inverse * (tr * x + ti * y);
  const float ly = inverse * (tr * y - ti * x);
  const float dx = at.Directions ? at.Directions[2 * q] : 0.0F;
  const float dy = at.Directions ? at.Directions[2 * q + 1] : 0.0F;
  const float* share = filter.Shares + (at.Shares ? at.Shares[q] : 0) * K;
  for (int j = 0; j < K; ++j)
  {
    const float ax = filter.Aligned[j];
    const float ay = filter.Aligned[K + j];
    const float bx = filter.Directed[j];
    const float by = filter.Directed[K + j];
    out.Constant[j] = share[j] + filter.Radius[j] * radius;
    out.ByReal[j] = ax * lx + ay * ly + bx * dx + by * dy;
    out.ByImaginary[j] = ax * ly - ay * lx + bx * dy - by * dx;
  }
  out.Re = at.Weights[e] * tr;
  out.Im = at.Weights[e] * ti;
}

/// Most edges whose numbers are prepared together.
constexpr int EdgesAtOnce = 16;

/// Adds edges for Lanes channels (or @p count, fewer) to the sums in @p re and @p im.
SURFSYNTH_INLINE void AddEdges(const EdgeNumbers* numbers, const std::int32_t* sources, int edges,
  const FieldFilter& filter, const float* features, const float* units, Size channels, Size count, Vector* re,
  Vector* im)
{
  for (int e = 0; e < edges; ++e)
  {
    const EdgeNumbers& edge = numbers[e];
    const Size row = sources[e] * 2 * channels;
    const Vector ur = Load(units + row, count);
    const Vector ui = Load(units + row + channels, count);
    Vector first[K];
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j)
    {
      first[j] = Relu(edge.Constant[j] + edge.ByReal[j] * ur + edge.ByImaginary[j] * ui);
    }
    const Vector fr = Load(features + row, count);
    const Vector fi = Load(features + row + channels, count);
    const Vector xr = edge.Re * fr - edge.Im * fi;
    const Vector xi = edge.Re * fi + edge.Im * fr;
#pragma GCC unroll 8
    for (int k = 0; k < K; ++k)
    {
      Vector sum = filter.Bias[k] + filter.Hidden[k * K] * first[0];
#pragma GCC unroll 8
      for (int j = 1; j < K; ++j)
      {
        sum += filter.Hidden[k * K + j] * first[j];
      }
      sum = Relu(sum);
      re[k] += sum * xr;
      im[k] += sum * xi;
    }
  }
}

SURFSYNTH_INLINE void GatherVertex(const FieldNeighborhoods& at, const FieldFilter& filter, const float* features,
  const float* units, Size v, Size channels, float* out)
{
  EdgeNumbers numbers[EdgesAtOnce];
  for (std::int32_t begin = at.Start[v]; begin < at.Start[v + 1]; begin += EdgesAtOnce)
  {
    const int rest = at.Start[v + 1] - begin;
    const int edges = rest < EdgesAtOnce ? rest : EdgesAtOnce;
    for (int e = 0; e < edges; ++e)
    {
      Prepare(at, filter, begin + e, numbers[e]);
    }
    for (Size c = 0; c < channels; c += Lanes)
    {
      const Size count = channels - c < Lanes ? channels - c : Lanes;
      Vector re[K] = {};
      Vector im[K] = {};
      if (begin > at.Start[v])
      {
        for (int k = 0; k < K; ++k)
        {
          re[k] = Load(out + 2 * k * channels + c, count);
          im[k] = Load(out + (2 * k + 1) * channels + c, count);
        }
      }
      AddEdges(numbers, at.Sources + begin, edges, filter, features + c, units + c, channels, count, re, im);
#pragma GCC unroll 8
      for (int k = 0; k < K; ++k)
      {
        Store(re[k], out + 2 * k * channels + c, count);
        Store(im[k], out + (2 * k + 1) * channels + c, count);
      }
    }
  }
}

void GatherFields(const FieldNeighborhoods& at, const FieldFilter& filter, const float* features, const float* units,
  Size first, Size rows, Size channels, float* out)
{
  for (Size row = 0; row < rows; ++row)
  {
    GatherVertex(at, filter, features, units, first + row, channels, out + row * 2 * K * channels);
  }
}

void Units(const float* __restrict__ x, Size rows, Size channels, float* __restrict__ units)
{
  for (Size row = 0; row < rows; ++row, x += 2 * channels, units += 2 * channels)
  {
    for (Size c = 0; c < channels; ++c)
    {
      const float re = x[c];
      const float im = x[channels + c];
      const float inverse = 1.0F / __builtin_sqrtf(re * re + im * im + 1e-6F);
      units[c] = inverse * re;
      units[channels + c] = inverse * im;
    }
  }
}

void Squares(const float* __restrict__ x, Size rows, Size channels, float* __restrict__ sums)
{
  for (Size c = 0; c < channels; ++c)
  {
    sums[c] = 0.0F;
  }
  for (Size row = 0; row < rows; ++row, x += 2 * channels)
  {
    for (Size c = 0; c < channels; ++c)
    {
      sums[c] += x[c] * x[c] + x[channels + c] * x[channels + c];
    }
  }
}
} // namespace

extern const LatentDiffusionKernels SURFSYNTH_KERNELS = { GatherFields, Units, Squares };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
