// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/DisplacementMap.h"

#include "Core/Atlas/SurfaceFrames.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/SubdivisionPlaces.h"
#include "Core/Mesh/TriangleTree.h"
#include "Core/Mesh/WeldedPoints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

namespace surfsynth
{

namespace
{
/// Texels between two reports of progress.
constexpr std::int64_t TexelsOfStep = 32768;
/// Least texels that pay for a thread.
constexpr std::int64_t TexelGrain = 256;

/// Brings both surfaces to about unit size by a power of two, which changes no digit. @return the exponent
int ScaleToUnitSize(TriangleMesh& plain, TriangleMesh& detailed)
{
  int exponent = 0;
  std::frexp(std::max(ComputeBoundingBox(plain).LongestSide(), ComputeBoundingBox(detailed).LongestSide()), &exponent);
  for (TriangleMesh* mesh : { &plain, &detailed })
  {
    for (Eigen::Index k = 0; k < mesh->Points.size(); ++k)
    {
      mesh->Points.data()[k] = std::ldexp(mesh->Points.data()[k], -exponent);
    }
  }
  return exponent;
}

/// What a texel is made of.
struct Texel
{
  Eigen::Vector3d Displacement;
  double Height = 0.0;
  double Miss = -1.0; ///< negative for none
};

/// Surfaces, and what is found once for all texels. Owns all it works on, so that it can be made in the background.
class Baker
{
public:
  Baker(const TriangleMesh& plain, const TextureCoordinates& coordinates, const TriangleMesh& detailed,
    const DisplacementMapOptions& options)
    : Plain(plain)
    , Detailed(detailed)
    , Coordinates(coordinates)
    , Options(options)
  {}
  Baker(const Baker&) = delete;
  Baker& operator=(const Baker&) = delete;

  /// Finds all that texels need.
  void Prepare()
  {
    this->Exponent = ScaleToUnitSize(this->Plain, this->Detailed);
    const BoundingBox box = ComputeBoundingBox(this->Plain);
    const double distance = std::ldexp(this->Options.MaximumDistance, -this->Exponent);
    this->Limit = distance > 0.0 ? distance : 0.1 * (box.Upper - box.Lower).norm();
    const std::vector<Index> classes = WeldPoints(this->Plain);
    if (this->Options.ByIndex)
    {
      this->Places = SubdivisionPlaces::Find(this->Plain, classes, this->Detailed);
    }
    this->Frames.emplace(this->Plain, classes, this->Coordinates);
    this->Raster = RasterizeAtlas(this->Coordinates, this->Options.Raster);
    this->Tree.emplace(
      this->Detailed, std::vector<Index>(static_cast<std::size_t>(this->Detailed.NumberOfTriangles()), 0));
  }

  Texel Bake(const SurfacePlace& place) const
  {
    const Eigen::Vector3d origin = PositionOf(this->Plain, place);
    const SurfaceFrame frame = this->Frames->FrameAt(place);
    Texel texel;
    LineHit hit;
    hit.Way = this->Limit;
    this->Tree->FindOnLine(origin, frame.Normal, hit);
    texel.Height = hit.Way;
    texel.Displacement = hit.Way * frame.Normal;
    if (hit.Place.Triangle < 0)
    {
      NearestPlace nearest;
      this->Tree->FindIn(0, origin, nearest);
      texel.Displacement = nearest.Position - origin;
      texel.Height = texel.Displacement.dot(frame.Normal);
      texel.Miss = (texel.Displacement - texel.Height * frame.Normal).norm();
    }
    if (this->Places)
    {
      texel.Displacement = PositionOf(this->Detailed, this->Places->OnSubdivision(place)) - origin;
    }
    if (this->Options.Space == DisplacementSpace::Tangent)
    {
      const Eigen::Vector3d d = texel.Displacement;
      texel.Displacement << frame.Tangent.dot(d), frame.Normal.dot(d), frame.Bitangent.dot(d);
    }
    return texel;
  }

  /// A length in world units.
  double InWorld(double length) const { return std::ldexp(length, this->Exponent); }

  AtlasRaster Raster;
  std::optional<SubdivisionPlaces> Places;

private:
  TriangleMesh Plain;
  TriangleMesh Detailed;
  TextureCoordinates Coordinates;
  DisplacementMapOptions Options;
  int Exponent = 0;
  double Limit = 0.0;
  std::optional<SurfaceFrames> Frames;
  std::optional<TriangleTree> Tree;
};

/// Prepares in the background: a cancelled preparation ends there.
std::shared_ptr<Baker> PreparedBaker(const TriangleMesh& plain, const TextureCoordinates& coordinates,
  const TriangleMesh& detailed, const DisplacementMapOptions& options, const Progress& progress)
{
  const auto baker = std::make_shared<Baker>(plain, coordinates, detailed, options);
  const double texels = static_cast<double>(options.Raster.Width) * options.Raster.Height;
  const double seconds = 0.02 + 5e-8 * texels + 2e-6 * (plain.NumberOfTriangles() + detailed.NumberOfTriangles());
  const int threads = MaximumThreads();
  RunCancellable(
    [baker, threads] {
      const ThreadScope scope(threads);
      baker->Prepare();
    },
    seconds, progress);
  return baker;
}

/// Numbers of the texels that show the surface, by triangle, so that searches near each other follow each other.
std::vector<std::uint32_t> FilledTexels(const AtlasRaster& raster)
{
  std::vector<std::uint32_t> texels;
  for (std::size_t t = 0; t < raster.Places.size(); ++t)
  {
    if (raster.Places[t].Triangle >= 0)
    {
      texels.push_back(static_cast<std::uint32_t>(t));
    }
  }
  std::stable_sort(texels.begin(), texels.end(),
    [&](std::uint32_t a, std::uint32_t b) { return raster.Places[a].Triangle < raster.Places[b].Triangle; });
  return texels;
}

/// Adds up the misses and the range of heights of covered texels, in their order.
class Measures
{
public:
  explicit Measures(DisplacementMap& map)
    : Map(map)
  {}

  void Add(float height, double miss)
  {
    const bool isFirst = this->Map.CoveredTexels++ == 0;
    this->Map.LowestHeight = isFirst ? height : std::min(this->Map.LowestHeight, height);
    this->Map.HighestHeight = isFirst ? height : std::max(this->Map.HighestHeight, height);
    if (miss >= 0.0)
    {
      ++this->Map.Misses;
      this->Sum += miss;
      this->Map.LargestMiss = std::max(this->Map.LargestMiss, miss);
      this->Map.MeanMiss = this->Sum / static_cast<double>(this->Map.Misses);
    }
  }

private:
  DisplacementMap& Map;
  double Sum = 0.0;
};

/// Bakes the texels @p ids into the images.
void BakeTexels(
  const Baker& baker, const std::uint32_t* ids, std::int64_t count, DisplacementMap& map, Measures& measures)
{
  std::vector<double> misses(static_cast<std::size_t>(count));
  ParallelFor(count, TexelGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      const std::size_t t = ids[k];
      const Texel texel = baker.Bake(baker.Raster.Places[t]);
      for (std::size_t c = 0; c < 3; ++c)
      {
        const double value = baker.InWorld(texel.Displacement[static_cast<Eigen::Index>(c)]);
        map.Displacements[3 * t + c] = static_cast<float>(value);
      }
      map.Heights[t] = static_cast<float>(baker.InWorld(texel.Height));
      misses[static_cast<std::size_t>(k)] = texel.Miss < 0.0 ? -1.0 : baker.InWorld(texel.Miss);
    }
  });
  for (std::int64_t k = 0; k < count; ++k)
  {
    const std::size_t t = ids[k];
    const TexelKind kind = baker.Raster.Kinds[t];
    if (kind == TexelKind::Covered || kind == TexelKind::Overlapped)
    {
      map.Coverage[t] = 255;
      measures.Add(map.Heights[t], misses[static_cast<std::size_t>(k)]);
    }
  }
}
} // namespace

DisplacementMap BakeDisplacementMap(const TriangleMesh& plain, const TextureCoordinates& coordinates,
  const TriangleMesh& detailed, const DisplacementMapOptions& options, const Progress& progress)
{
  const auto baker = PreparedBaker(plain, coordinates, detailed, options, SubProgress(progress, 0.0, 0.2));
  DisplacementMap map;
  const std::size_t size = baker->Raster.Places.size();
  map.Displacements.resize(3 * size);
  map.Heights.resize(size);
  map.Coverage.resize(size);
  map.SubdivisionLevels = baker->Places ? baker->Places->NumberOfLevels() : -1;
  map.Findings = baker->Raster.Findings;
  const std::vector<std::uint32_t> texels = FilledTexels(baker->Raster);
  const auto count = static_cast<std::int64_t>(texels.size());
  Measures measures(map);
  for (std::int64_t begin = 0; begin < count; begin += TexelsOfStep)
  {
    Report(progress, 0.2 + 0.8 * static_cast<double>(begin) / static_cast<double>(count));
    BakeTexels(*baker, texels.data() + begin, std::min(TexelsOfStep, count - begin), map, measures);
  }
  Report(progress, 1.0);
  return map;
}

} // namespace surfsynth
