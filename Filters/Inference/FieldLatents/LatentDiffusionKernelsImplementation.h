// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Loops of LatentDiffusionKernels.h. Each source that includes this names its variant in SURFSYNTH_KERNELS. Private to
/// the inference; includes no standard header but <cstdint>: see ActivationKernelsImplementation.h.
#pragma once

#include "Inference/Common/ElementaryFunctions.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"

#if defined(__AVX__)
#include <immintrin.h> // only functions that are always inlined
#endif

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

/// @tparam Whole true for Lanes numbers, without a look at @p count
template <bool Whole>
SURFSYNTH_INLINE Vector Load(const float* from, Size count)
{
  Vector value = {};
  __builtin_memcpy(&value, from, Whole ? sizeof(value) : static_cast<decltype(sizeof(float))>(4 * count));
  return value;
}

template <bool Whole>
SURFSYNTH_INLINE void Store(const Vector& value, float* to, Size count)
{
  __builtin_memcpy(to, &value, Whole ? sizeof(value) : static_cast<decltype(sizeof(float))>(4 * count));
}

SURFSYNTH_INLINE Vector Relu(const Vector& value)
{
#if defined(__AVX512F__)
  // One instruction, where the expression below becomes two.
  return _mm512_maskz_max_ps(static_cast<__mmask16>(-1), value, _mm512_setzero_ps());
#elif defined(__AVX__)
  return _mm256_max_ps(value, _mm256_setzero_ps());
#else
  return value > 0.0F ? value : Vector{};
#endif
}

/// Sets vectors to 0.
template <int Count>
SURFSYNTH_INLINE void Clear(Vector* values)
{
#pragma GCC unroll 8
  for (int k = 0; k < Count; ++k)
  {
    values[k] = Vector{};
  }
}

/// Numbers of one edge that all channels share.
struct EdgeNumbers
{
  float Constant[K]; ///< share, bias and radius in the first layer
  float ByReal[K];   ///< factors of the real part of the unit feature at the source, in the frame of the source
  float ByImaginary[K];
  float Re; ///< weight times transport
  float Im;
  float Radius; ///< length of the logarithm
  float LogX;   ///< direction of the logarithm in the frame of the source
  float LogY;
};

/// Tangent vector at a source in its frame, which guides the filter; 0 without.
struct SourceGuide
{
  float X;
  float Y;
};

SURFSYNTH_INLINE SourceGuide GuideOf(const float* vectors, Size q)
{
  return vectors ? SourceGuide{ vectors[2 * q], vectors[2 * q + 1] } : SourceGuide{ 0.0F, 0.0F };
}

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
  const SourceGuide centroid = GuideOf(at.Centroids, q);
  const SourceGuide direction = GuideOf(at.Directions, q);
  const float* share = filter.Shares + (at.Shares ? at.Shares[q] : 0) * K;
  for (int j = 0; j < K; ++j)
  {
    const float ax = filter.Aligned[j];
    const float ay = filter.Aligned[K + j];
    const float bx = filter.Centroids[j];
    const float by = filter.Centroids[K + j];
    const float cx = filter.Directed[j];
    const float cy = filter.Directed[K + j];
    out.Constant[j] = share[j] + filter.Radius[j] * radius;
    out.ByReal[j] = ax * lx + ay * ly + bx * centroid.X + by * centroid.Y + cx * direction.X + cy * direction.Y;
    out.ByImaginary[j] = ax * ly - ay * lx + bx * centroid.Y - by * centroid.X + cx * direction.Y - cy * direction.X;
  }
  out.Re = at.Weights[e] * tr;
  out.Im = at.Weights[e] * ti;
  out.Radius = radius;
  out.LogX = lx;
  out.LogY = ly;
}

/// Most edges whose numbers are prepared together.
constexpr int EdgesAtOnce = 16;

/// Adds edges for Lanes channels (or @p count, fewer) to the sums in @p re and @p im.
template <bool Whole>
SURFSYNTH_INLINE void AddEdges(const EdgeNumbers* numbers, const std::int32_t* sources, int edges,
  const FieldFilter& filter, const float* features, const float* units, Size channels, Size count, Vector* re,
  Vector* im)
{
  for (int e = 0; e < edges; ++e)
  {
    const EdgeNumbers& edge = numbers[e];
    const Size row = sources[e] * 2 * channels;
    const Vector ur = Load<Whole>(units + row, count);
    const Vector ui = Load<Whole>(units + row + channels, count);
    Vector first[K];
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j)
    {
      first[j] = Relu(edge.Constant[j] + edge.ByReal[j] * ur + edge.ByImaginary[j] * ui);
    }
    const Vector fr = Load<Whole>(features + row, count);
    const Vector fi = Load<Whole>(features + row + channels, count);
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

/// Sums of one vertex over edges for some channels. @param more true to add to @p out
template <bool Whole>
SURFSYNTH_INLINE void GatherLanes(const EdgeNumbers* numbers, const std::int32_t* sources, int edges,
  const FieldFilter& filter, const float* features, const float* units, Size channels, Size count, bool more,
  float* out)
{
  Vector re[K];
  Vector im[K];
  Clear<K>(re);
  Clear<K>(im);
  if (more)
  {
    for (int k = 0; k < K; ++k)
    {
      re[k] = Load<Whole>(out + 2 * k * channels, count);
      im[k] = Load<Whole>(out + (2 * k + 1) * channels, count);
    }
  }
  AddEdges<Whole>(numbers, sources, edges, filter, features, units, channels, count, re, im);
#pragma GCC unroll 8
  for (int k = 0; k < K; ++k)
  {
    Store<Whole>(re[k], out + 2 * k * channels, count);
    Store<Whole>(im[k], out + (2 * k + 1) * channels, count);
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
    const std::int32_t* sources = at.Sources + begin;
    const bool more = begin > at.Start[v];
    for (Size c = 0; c < channels; c += Lanes)
    {
      const Size count = channels - c;
      if (count >= Lanes)
      {
        GatherLanes<true>(numbers, sources, edges, filter, features + c, units + c, channels, Lanes, more, out + c);
      }
      else
      {
        GatherLanes<false>(numbers, sources, edges, filter, features + c, units + c, channels, count, more, out + c);
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

/// Edges whose hidden layers are kept together for the derivatives by the weights.
constexpr int TapedEdges = 8;

/// Hidden layers of some edges, and the derivatives by them.
struct EdgeTape
{
  Vector First[TapedEdges][K];    ///< first layer
  Vector ByFirst[TapedEdges][K];  ///< by its arguments
  Vector ByHidden[TapedEdges][K]; ///< by the arguments of the second layer
  Vector Cosine[TapedEdges];      ///< of the aligned angle
  Vector Sine[TapedEdges];
};

/// Derivatives by the weights of a filter, for each lane.
struct FilterSums
{
  Vector Radius[K];
  Vector Aligned[2 * K];
  Vector Centroids[2 * K];
  Vector Directed[2 * K];
  Vector Hidden[K * K];
  Vector Bias[K];
};

/// Features of one source in some channels and the derivatives by them.
struct SourceLanes
{
  Vector Re;
  Vector Im;
  Vector UnitRe;
  Vector UnitIm;
  Vector ByRe;
  Vector ByIm;
  Vector ByUnitRe;
  Vector ByUnitIm;
};

/// Adds the derivatives by the features that come through one edge. @param dSum [K, 2 C] of the target, from the channel on
template <bool Whole>
SURFSYNTH_INLINE void AddEdgeGradient(const EdgeNumbers& edge, const FieldFilter& filter, const float* dSum,
  Size channels, Size count, Vector* first, Vector* byFirst, Vector* byHidden, SourceLanes& at)
{
#pragma GCC unroll 8
  for (int j = 0; j < K; ++j)
  {
    first[j] = Relu(edge.Constant[j] + edge.ByReal[j] * at.UnitRe + edge.ByImaginary[j] * at.UnitIm);
  }
  const Vector xr = edge.Re * at.Re - edge.Im * at.Im;
  const Vector xi = edge.Re * at.Im + edge.Im * at.Re;
  Vector byXr = {};
  Vector byXi = {};
#pragma GCC unroll 8
  for (int k = 0; k < K; ++k)
  {
    Vector hidden = filter.Bias[k] + filter.Hidden[k * K] * first[0];
#pragma GCC unroll 8
    for (int j = 1; j < K; ++j)
    {
      hidden += filter.Hidden[k * K + j] * first[j];
    }
    const Vector gr = Load<Whole>(dSum + 2 * k * channels, count);
    const Vector gi = Load<Whole>(dSum + (2 * k + 1) * channels, count);
    const Vector active = Relu(hidden);
    byXr += active * gr;
    byXi += active * gi;
    byHidden[k] = hidden > 0.0F ? gr * xr + gi * xi : Vector{};
  }
  at.ByRe += edge.Re * byXr + edge.Im * byXi;
  at.ByIm += edge.Re * byXi - edge.Im * byXr;
  // A loop of its own: sums beside those above would not fit into registers.
#pragma GCC unroll 8
  for (int j = 0; j < K; ++j)
  {
    Vector sum = filter.Hidden[j] * byHidden[0];
#pragma GCC unroll 8
    for (int k = 1; k < K; ++k)
    {
      sum += filter.Hidden[k * K + j] * byHidden[k];
    }
    byFirst[j] = first[j] > 0.0F ? sum : Vector{};
    at.ByUnitRe += edge.ByReal[j] * byFirst[j];
    at.ByUnitIm += edge.ByImaginary[j] * byFirst[j];
  }
}

/// Adds the derivatives by the weights of the hidden layer that come through the edges of a tape.
SURFSYNTH_INLINE void AddHiddenGradient(const EdgeTape& tape, int edges, FilterSums& sums)
{
#pragma GCC unroll 8
  for (int k = 0; k < K; ++k)
  {
    Vector row[K];
    Vector bias = sums.Bias[k];
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j)
    {
      row[j] = sums.Hidden[k * K + j];
    }
    for (int e = 0; e < edges; ++e)
    {
      const Vector by = tape.ByHidden[e][k];
      bias += by;
#pragma GCC unroll 8
      for (int j = 0; j < K; ++j)
      {
        row[j] += by * tape.First[e][j];
      }
    }
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j)
    {
      sums.Hidden[k * K + j] = row[j];
    }
    sums.Bias[k] = bias;
  }
}

/// Adds the derivatives by the weights that come through the edges of a tape. @param shares [K], those by the shares
SURFSYNTH_INLINE void AddFilterGradient(
  const EdgeTape& tape, const EdgeNumbers* numbers, int edges, Vector* shares, FilterSums& sums)
{
  AddHiddenGradient(tape, edges, sums);
  constexpr int pair = 2; // layers whose sums stay in registers together
  for (int j = 0; j < K; j += pair)
  {
    Vector share[pair];
    Vector radius[pair];
    Vector cosine[pair];
    Vector sine[pair];
#pragma GCC unroll 2
    for (int i = 0; i < pair; ++i)
    {
      share[i] = shares[j + i];
      radius[i] = sums.Radius[j + i];
      cosine[i] = sums.Aligned[j + i];
      sine[i] = sums.Aligned[K + j + i];
    }
    for (int e = 0; e < edges; ++e)
    {
#pragma GCC unroll 2
      for (int i = 0; i < pair; ++i)
      {
        const Vector by = tape.ByFirst[e][j + i];
        share[i] += by;
        radius[i] += numbers[e].Radius * by;
        cosine[i] += tape.Cosine[e] * by;
        sine[i] += tape.Sine[e] * by;
      }
    }
#pragma GCC unroll 2
    for (int i = 0; i < pair; ++i)
    {
      shares[j + i] = share[i];
      sums.Radius[j + i] = radius[i];
      sums.Aligned[j + i] = cosine[i];
      sums.Aligned[K + j + i] = sine[i];
    }
  }
}

SURFSYNTH_INLINE float SumOfLanes(const Vector& value)
{
  float sum = 0.0F;
  for (int lane = 0; lane < Lanes; ++lane)
  {
    sum += value[lane];
  }
  return sum;
}

/// Derivatives by some channels of one source, from @p edges edges, at most TapedEdges.
template <bool Whole>
SURFSYNTH_INLINE void AddSourceGradient(const EdgeNumbers* numbers, const std::int32_t* targets, int edges,
  const FieldFilter& filter, const float* dSums, Size channels, Size count, SourceLanes& at, Vector* shares,
  FilterSums& sums)
{
  EdgeTape tape;
  for (int e = 0; e < edges; ++e)
  {
    AddEdgeGradient<Whole>(numbers[e], filter, dSums + targets[e] * 2 * K * channels, channels, count, tape.First[e],
      tape.ByFirst[e], tape.ByHidden[e], at);
    tape.Cosine[e] = numbers[e].LogX * at.UnitRe + numbers[e].LogY * at.UnitIm;
    tape.Sine[e] = numbers[e].LogY * at.UnitRe - numbers[e].LogX * at.UnitIm;
  }
  AddFilterGradient(tape, numbers, edges, shares, sums);
}

/// Adds the derivatives by the weights [2, K] of a guide. @param shares [K], derivatives by the shares
SURFSYNTH_INLINE void AddGuideGradient(
  const SourceGuide& guide, const SourceLanes& at, const Vector* shares, Vector* sums)
{
  const Vector cosine = guide.X * at.UnitRe + guide.Y * at.UnitIm;
  const Vector sine = guide.Y * at.UnitRe - guide.X * at.UnitIm;
  for (int j = 0; j < K; ++j)
  {
    sums[j] += cosine * shares[j];
    sums[K + j] += sine * shares[j];
  }
}

/// Derivatives by some channels of source @p q from edges. @param more true to add to @p dFeatures
template <bool Whole>
SURFSYNTH_INLINE void GatherSourceLanes(const EdgeNumbers* numbers, const std::int32_t* targets, int edges,
  const FieldFilter& filter, const SourceGuide* guides, const float* features, const float* units, const float* dSums,
  Size channels, Size count, bool more, float* dFeatures, Vector* shares, FilterSums& sums)
{
  SourceLanes lanes = { Load<Whole>(features, count), Load<Whole>(features + channels, count),
    Load<Whole>(units, count), Load<Whole>(units + channels, count), {}, {}, {}, {} };
  Vector own[K];
  Clear<K>(own);
  AddSourceGradient<Whole>(numbers, targets, edges, filter, dSums, channels, count, lanes, own, sums);
  AddGuideGradient(guides[0], lanes, own, sums.Centroids);
  AddGuideGradient(guides[1], lanes, own, sums.Directed);
  for (int j = 0; j < K; ++j)
  {
    shares[j] += own[j];
  }
  // By x, of u = x / n with n^2 = |x|^2 + 1e-6: (du - u Re<u, du>) / n.
  const Vector square = lanes.Re * lanes.Re + lanes.Im * lanes.Im + 1e-6F;
  Vector inverse;
  for (int lane = 0; lane < Lanes; ++lane)
  {
    inverse[lane] = 1.0F / __builtin_sqrtf(square[lane]);
  }
  const Vector along = lanes.UnitRe * lanes.ByUnitRe + lanes.UnitIm * lanes.ByUnitIm;
  const Vector re = lanes.ByRe + inverse * (lanes.ByUnitRe - along * lanes.UnitRe);
  const Vector im = lanes.ByIm + inverse * (lanes.ByUnitIm - along * lanes.UnitIm);
  Store<Whole>(more ? Load<Whole>(dFeatures, count) + re : re, dFeatures, count);
  Store<Whole>(more ? Load<Whole>(dFeatures + channels, count) + im : im, dFeatures + channels, count);
}

/// Derivatives by the features of source @p q. @param shares [K], sums that are added to
SURFSYNTH_INLINE void GatherSourceGradient(const FieldNeighborhoods& at, const FieldSources& sources,
  const FieldFilter& filter, const float* features, const float* units, const float* dSums, Size q, Size channels,
  float* dFeatures, Vector* shares, FilterSums& sums)
{
  EdgeNumbers numbers[TapedEdges];
  const SourceGuide guides[2] = { GuideOf(at.Centroids, q), GuideOf(at.Directions, q) };
  for (std::int32_t begin = sources.Start[q]; begin < sources.Start[q + 1]; begin += TapedEdges)
  {
    const int rest = sources.Start[q + 1] - begin;
    const int edges = rest < TapedEdges ? rest : TapedEdges;
    for (int e = 0; e < edges; ++e)
    {
      Prepare(at, filter, sources.Edges[begin + e], numbers[e]);
    }
    const std::int32_t* targets = sources.Targets + begin;
    const bool more = begin > sources.Start[q];
    for (Size c = 0; c < channels; c += Lanes)
    {
      const Size count = channels - c;
      const Size row = q * 2 * channels + c;
      if (count >= Lanes)
      {
        GatherSourceLanes<true>(numbers, targets, edges, filter, guides, features + row, units + row, dSums + c,
          channels, Lanes, more, dFeatures + c, shares, sums);
      }
      else
      {
        GatherSourceLanes<false>(numbers, targets, edges, filter, guides, features + row, units + row, dSums + c,
          channels, count, more, dFeatures + c, shares, sums);
      }
    }
  }
}

SURFSYNTH_INLINE void AddLanes(const Vector* sums, int count, float* out)
{
  for (int k = 0; k < count; ++k)
  {
    out[k] += SumOfLanes(sums[k]);
  }
}

void GatherFieldsGradient(const FieldNeighborhoods& at, const FieldSources& sources, const FieldFilter& filter,
  const float* features, const float* units, const float* dSums, Size first, Size rows, Size channels, float* dFeatures,
  const FieldFilterGradient& gradient)
{
  FilterSums sums = {};
  Vector shares[K] = {};
  for (Size row = 0; row < rows; ++row)
  {
    const Size q = first + row;
    GatherSourceGradient(
      at, sources, filter, features, units, dSums, q, channels, dFeatures + 2 * row * channels, shares, sums);
    const bool last = row + 1 == rows || (at.Shares && at.Shares[q + 1] != at.Shares[q]);
    if (last)
    {
      AddLanes(shares, K, gradient.Shares + (at.Shares ? at.Shares[q] : 0) * K);
      for (int j = 0; j < K; ++j)
      {
        shares[j] = Vector{};
      }
    }
  }
  AddLanes(sums.Radius, K, gradient.Radius);
  AddLanes(sums.Aligned, 2 * K, gradient.Aligned);
  AddLanes(sums.Centroids, 2 * K, gradient.Centroids);
  AddLanes(sums.Directed, 2 * K, gradient.Directed);
  AddLanes(sums.Hidden, K * K, gradient.Hidden);
  AddLanes(sums.Bias, K, gradient.Bias);
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

extern const LatentDiffusionKernels SURFSYNTH_KERNELS = { GatherFields, GatherFieldsGradient, Units, Squares };

} // namespace surfsynth

#undef SURFSYNTH_INLINE
