// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/RingSamples.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterUniforms.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>

namespace surfsynth
{

namespace
{
/// Least rings of a range: each has some ten samples or more.
constexpr std::int64_t RingGrain = 256;
constexpr int MostSamples = 65536;
/// Rings with more triangles, and with more than their samples, do not have a sample in each triangle.
constexpr int LeastLargeRing = 1024;
/// Inverse of the plastic ratio x^3 = x + 1: its powers 1 and 2 make a low-discrepancy sequence of the unit square.
constexpr double PlasticRatio = 0.75487766624669276;
/// Tells these random numbers from others of the same seed.
constexpr std::uint32_t RingStream = 0x52494e47;

void RequireRings(const char* function, const OneRings& rings, const std::vector<Index>& vertices, int numberOfSamples)
{
  if (numberOfSamples < 1 || numberOfSamples > MostSamples)
  {
    throw InvalidInput(std::string(function) + ": " + std::to_string(numberOfSamples) +
      " samples of a ring; expected 1 to " + std::to_string(MostSamples) + ".");
  }
  const Index points = rings.NumberOfPoints();
  const auto wrong = std::find_if(vertices.begin(), vertices.end(), [&](Index v) { return v < 0 || v >= points; });
  if (wrong != vertices.end())
  {
    throw InvalidInput(std::string(function) + ": vertex " + std::to_string(*wrong) + "; expected ids in [0, " +
      std::to_string(points) + ").");
  }
}

double CornerArea(const RingCorner& corner) { return 0.5 * corner.Length * corner.OtherY; }

/// Number of samples of a ring with more triangles than that.
std::int64_t MostOfRing(int numberOfSamples) { return std::max<std::int64_t>(LeastLargeRing, numberOfSamples); }

bool IsLarge(const OneRings& rings, Index v, int numberOfSamples)
{
  return rings.RingStart[v + 1] - rings.RingStart[v] > MostOfRing(numberOfSamples);
}

/// Number of samples of a triangle with the share @p share of its ring's area.
std::int64_t SamplesOfShare(double share, int numberOfSamples)
{
  // Shares that differ by rounding only, such as those of equal triangles, get equal numbers.
  return std::max<std::int64_t>(1, std::llround(share * numberOfSamples - 1e-6));
}

/// Writes one sample of the triangle of corner @p c: its part @p s of the area lies nearer to p, and @p t is the
/// position between a and b.
void WriteSample(const OneRings& rings, Index c, double s, double t, RingSamples& samples, std::int64_t at)
{
  const double far = std::sqrt(s);
  const double weightB = far * t;
  const double weightA = far - weightB;
  SurfacePlace& place = samples.Places[at];
  place.Triangle = c / 3;
  place.Weights[c % 3] = 1.0 - far;
  place.Weights[(c % 3 + 1) % 3] = weightA;
  place.Weights[(c % 3 + 2) % 3] = weightB;
  samples.Logarithms[at] = rings.Corners[c].Logarithm(weightA, weightB);
}

/// Writes the samples of a ring of vertex @p v with more triangles than samples: sample i of n lies in the triangle that
/// holds the fraction (i + 1/2) / n of the ring's area, counted from its largest triangle.
void SampleLargeRing(const OneRings& rings, Index v, std::int64_t count, RingSamples& samples, std::int64_t at)
{
  const auto first = rings.RingCorners.begin() + rings.RingStart[v];
  const auto last = rings.RingCorners.begin() + rings.RingStart[v + 1];
  const auto largest = std::max_element(
    first, last, [&rings](Index a, Index b) { return CornerArea(rings.Corners[a]) < CornerArea(rings.Corners[b]); });
  auto corner = largest;
  double reached = CornerArea(rings.Corners[*corner]);
  for (std::int64_t i = 0; i < count; ++i)
  {
    const double middle = static_cast<double>(i) + 0.5;
    const double wanted = rings.Areas[v] * middle / static_cast<double>(count);
    while (wanted > reached)
    {
      const auto next = std::next(corner) == last ? first : std::next(corner);
      if (next == largest)
      {
        break; // rounding errors of the sum
      }
      corner = next;
      reached += CornerArea(rings.Corners[*corner]);
    }
    const double s = middle * PlasticRatio;
    const double t = s * PlasticRatio;
    WriteSample(rings, *corner, s - std::floor(s), t - std::floor(t), samples, at + i);
  }
}

/// Makes room for the samples, with @p count(v) of vertex v.
template <typename Count>
RingSamples WithOffsets(const std::vector<Index>& vertices, const Count& count)
{
  RingSamples samples;
  samples.Offsets.assign(vertices.size() + 1, 0);
  ParallelFor(static_cast<std::int64_t>(vertices.size()), RingGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      samples.Offsets[k + 1] = count(vertices[k]);
    }
  });
  std::partial_sum(samples.Offsets.begin(), samples.Offsets.end(), samples.Offsets.begin());
  samples.Places.resize(static_cast<std::size_t>(samples.Offsets.back()));
  samples.Logarithms.resize(samples.Places.size());
  return samples;
}
} // namespace

RingSamples SampleRingsUniformly(const OneRings& rings, const std::vector<Index>& vertices, int numberOfSamples)
{
  RequireRings("SampleRingsUniformly", rings, vertices, numberOfSamples);
  const auto ofCorner = [&](Index v, Index c) {
    return SamplesOfShare(CornerArea(rings.Corners[c]) / rings.Areas[v], numberOfSamples);
  };
  const auto ofVertex = [&](Index v) {
    if (IsLarge(rings, v, numberOfSamples))
    {
      return MostOfRing(numberOfSamples);
    }
    return std::accumulate(rings.RingCorners.begin() + rings.RingStart[v],
      rings.RingCorners.begin() + rings.RingStart[v + 1], std::int64_t(0),
      [&](std::int64_t sum, Index c) { return sum + ofCorner(v, c); });
  };
  RingSamples samples = WithOffsets(vertices, ofVertex);
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  ParallelFor(static_cast<std::int64_t>(vertices.size()), RingGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      const Index v = vertices[k];
      std::int64_t at = samples.Offsets[k];
      if (IsLarge(rings, v, numberOfSamples))
      {
        SampleLargeRing(rings, v, samples.Offsets[k + 1] - at, samples, at);
        continue;
      }
      for (Index r = rings.RingStart[v]; r < rings.RingStart[v + 1]; ++r)
      {
        const Index c = rings.RingCorners[r];
        const std::int64_t count = ofCorner(v, c);
        for (std::int64_t i = 0; i < count; ++i, ++at)
        {
          const double middle = static_cast<double>(i) + 0.5;
          const double t = middle * golden;
          WriteSample(rings, c, middle / static_cast<double>(count), t - std::floor(t), samples, at);
        }
      }
    }
  });
  return samples;
}

RingSamples SampleRingsUniformly(const OneRings& rings, int numberOfSamples)
{
  std::vector<Index> all(static_cast<std::size_t>(rings.NumberOfPoints()));
  std::iota(all.begin(), all.end(), 0);
  return SampleRingsUniformly(rings, all, numberOfSamples);
}

RingSamples SampleRingsAtRandom(const OneRings& rings, const std::vector<Index>& vertices, int numberOfSamples,
  std::uint64_t seed, std::uint32_t sample)
{
  RequireRings("SampleRingsAtRandom", rings, vertices, numberOfSamples);
  RingSamples samples = WithOffsets(
    vertices, [&](Index v) { return rings.RingStart[v + 1] > rings.RingStart[v] ? std::int64_t(numberOfSamples) : 0; });
  ParallelFor(static_cast<std::int64_t>(vertices.size()), RingGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      const Index v = vertices[k];
      const Index last = rings.RingStart[v + 1] - 1;
      Index r = rings.RingStart[v];
      double reached = r <= last ? CornerArea(rings.Corners[rings.RingCorners[r]]) : 0.0;
      NormalKey key{ seed, sample, 0, RingStream };
      for (std::int64_t at = samples.Offsets[k]; at < samples.Offsets[k + 1]; ++at, ++key.Component)
      {
        const auto uniform = [&](int coordinate) { return Uniform(key, 4 * std::int64_t(v) + coordinate); };
        const double wanted = rings.Areas[v] * (key.Component + uniform(0)) / numberOfSamples;
        while (wanted > reached && r < last)
        {
          ++r;
          reached += CornerArea(rings.Corners[rings.RingCorners[r]]);
        }
        WriteSample(rings, rings.RingCorners[r], uniform(1), uniform(2), samples, at);
      }
    }
  });
  return samples;
}

} // namespace surfsynth
