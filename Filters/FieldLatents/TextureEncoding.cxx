// SPDX-License-Identifier: BSD-3-Clause
#include "TextureEncoding.h"

#include "SurfaceArrays.h"

#include "Core/Tangent/RingSamples.h"

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>

namespace surfsynth
{

namespace
{
/// Samples that are held at once: about 9 MiB.
constexpr std::size_t SamplesOfTile = 131072;
/// Largest number of samples of a ring, whatever the model advises.
constexpr std::int64_t MaximumSamples = 4096;
/// Fraction of the work on a tile in which its colors are sampled.
constexpr double OfSampling = 0.1;

/// Samples the colors in the rings of @p vertices.
FieldLatentRings SampleColors(const WeldedSurface& welded, const ColorSource& colors,
  const std::vector<Index>& vertices, int samplesPerRing, const Progress& progress)
{
  const RingSamples samples = SampleRingsUniformly(welded.Rings, vertices, samplesPerRing);
  Report(progress, 0.5);
  const auto count = static_cast<Eigen::Index>(samples.Places.size());
  FieldLatentRings rings;
  rings.Offsets = samples.Offsets;
  rings.Colors.resize(count, 3);
  rings.Logarithms.resize(count, 2);
  colors(samples.Places.data(), count, rings.Colors.data());
  for (std::size_t k = 0; k < vertices.size(); ++k)
  {
    const double radius = welded.Rings.RingRadius(vertices[k]);
    for (std::int64_t s = samples.Offsets[k]; s < samples.Offsets[k + 1]; ++s)
    {
      const std::complex<double> z = samples.Logarithms[static_cast<std::size_t>(s)] / radius;
      rings.Logarithms.row(s) << static_cast<float>(z.real()), static_cast<float>(z.imag());
    }
  }
  return rings;
}

/// Returns the end of the tile of vertices that begins at place @p begin: about SamplesOfTile samples, at least a vertex.
std::size_t EndOfTile(const OneRings& rings, const std::vector<Index>& vertices, std::size_t begin, int samplesPerRing)
{
  std::size_t end = begin;
  std::size_t samples = 0;
  while (end < vertices.size() && samples < SamplesOfTile)
  {
    // A ring has at least a sample in each of its triangles.
    const auto triangles = rings.RingStart[vertices[end] + 1] - rings.RingStart[vertices[end]];
    samples += static_cast<std::size_t>(samplesPerRing) + static_cast<std::size_t>(triangles);
    ++end;
  }
  return end;
}
} // namespace

ColorSource ColorsOn(const TextureColors& colors)
{
  return [&colors](const SurfacePlace* places, std::int64_t count, float* out) { colors.Sample(places, count, out); };
}

ColorSource ColorsOfNearest(const TriangleMesh& encoded, const TriangleMesh& source, const TextureColors& colors)
{
  const auto nearest = std::make_shared<const NearestPlaces>(source);
  return [&encoded, &colors, nearest](const SurfacePlace* places, std::int64_t count, float* out) {
    PointMatrix points(count, 3);
    for (std::int64_t k = 0; k < count; ++k)
    {
      points.row(k) = PositionOf(encoded, places[k]).transpose();
    }
    const std::vector<SurfacePlace> found = nearest->Find(points);
    colors.Sample(found.data(), count, out);
  };
}

std::vector<Index> VerticesOf(const WeldedSurface& welded)
{
  std::vector<Index> vertices;
  for (Index v = 0; v < welded.Rings.NumberOfPoints(); ++v)
  {
    if (welded.IsVertex(v))
    {
      vertices.push_back(v);
    }
  }
  return vertices;
}

int DiffusionSamplesPerRing(const FieldLatentEncoder& encoder)
{
  return static_cast<int>(std::clamp<std::int64_t>(encoder.Options().SamplesPerRing, 128, MaximumSamples));
}

FieldLatentCodes EncodeColors(const FieldLatentEncoder& encoder, const WeldedSurface& welded, const ColorSource& colors,
  const std::vector<Index>& vertices, int samplesPerRing, const Progress& progress)
{
  const int samples = samplesPerRing > 0 ? samplesPerRing
                                         : static_cast<int>(std::min(encoder.Options().SamplesPerRing, MaximumSamples));
  const std::int64_t dimension = encoder.Options().LatentDimension;
  FieldLatentCodes codes;
  codes.Mean = FieldLatentMatrix::Zero(welded.Rings.NumberOfPoints(), 2 * dimension);
  codes.LogDeviation = FieldLatentMatrix::Zero(welded.Rings.NumberOfPoints(), dimension);
  const auto share = [&](std::size_t k) { return static_cast<double>(k) / static_cast<double>(vertices.size()); };
  for (std::size_t begin = 0, end = 0; begin < vertices.size(); begin = end)
  {
    end = EndOfTile(welded.Rings, vertices, begin, samples);
    const Progress part = SubProgress(progress, share(begin), share(end));
    Report(part, 0.0);
    const std::vector<Index> tile(vertices.data() + begin, vertices.data() + end);
    const FieldLatentRings rings = SampleColors(welded, colors, tile, samples, SubProgress(part, 0.0, OfSampling));
    const FieldLatentCodes found = encoder.Encode(rings, SubProgress(part, OfSampling, 1.0));
    for (std::size_t k = 0; k < tile.size(); ++k)
    {
      codes.Mean.row(tile[k]) = found.Mean.row(static_cast<Eigen::Index>(k));
      codes.LogDeviation.row(tile[k]) = found.LogDeviation.row(static_cast<Eigen::Index>(k));
    }
  }
  return codes;
}

} // namespace surfsynth
