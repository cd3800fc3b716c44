// SPDX-License-Identifier: BSD-3-Clause
#include "AtlasPlaces.h"

#include "SurfaceArrays.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/UsedPoints.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <numeric>
#include <unordered_map>

namespace surfsynth
{

namespace
{
/// Places searched between two reports of progress.
constexpr std::size_t PlacesOfStep = 65536;

/// Hash of the triangle and the bits of the barycentric coordinates.
std::uint64_t HashOf(const SurfacePlace& place)
{
  std::uint64_t hash = static_cast<std::uint32_t>(place.Triangle) * 0x9E3779B97F4A7C15ULL;
  for (int k = 0; k < 3; ++k)
  {
    std::uint64_t bits = 0;
    std::memcpy(&bits, place.Weights.data() + k, sizeof bits);
    hash = (hash ^ bits ^ (bits >> 29U)) * 0xBF58476D1CE4E5B9ULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

bool AreEqual(const SurfacePlace& a, const SurfacePlace& b)
{
  return a.Triangle == b.Triangle && a.Weights == b.Weights;
}

/// True for a texel from which gutters may be filled: one with an empty or gutter texel beside it.
bool IsAtGutter(const AtlasRaster& raster, std::size_t texel)
{
  const int width = raster.Width;
  const auto i = static_cast<int>(texel % static_cast<std::size_t>(width));
  const auto j = static_cast<int>(texel / static_cast<std::size_t>(width));
  for (int y = std::max(0, j - 1); y <= std::min(raster.Height - 1, j + 1); ++y)
  {
    for (int x = std::max(0, i - 1); x <= std::min(width - 1, i + 1); ++x)
    {
      if (raster.Kinds[static_cast<std::size_t>(y) * width + x] == TexelKind::Gutter)
      {
        return true;
      }
    }
  }
  return false;
}

/// Orders places by triangle, so that what belongs to a vertex is used again soon; those of one triangle stay in order.
/// A counting sort, linear in places and triangles.
void OrderByTriangle(DecodedPlaces& places)
{
  const auto triangleOf = [&](std::uint32_t k) { return static_cast<std::size_t>(places.Places[k].Triangle); };
  std::size_t triangles = 0;
  for (const std::uint32_t k : places.Decoded)
  {
    triangles = std::max(triangles, triangleOf(k) + 1);
  }
  std::vector<std::size_t> next(triangles + 1, 0); // of each triangle, the place in the order
  for (const std::uint32_t k : places.Decoded)
  {
    ++next[triangleOf(k) + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<std::uint32_t> ordered(places.Decoded.size());
  for (const std::uint32_t k : places.Decoded)
  {
    ordered[next[triangleOf(k)]++] = k;
  }
  places.Decoded = std::move(ordered);
}

/// Returns the places of the points of a welded surface themselves.
DecodedPlaces PlacesOfPoints(const WeldedSurface& welded)
{
  DecodedPlaces points;
  points.Places.resize(welded.VertexOfPoint.size());
  for (std::size_t p = 0; p < points.Places.size(); ++p)
  {
    const Index v = welded.VertexOfPoint[p];
    if (welded.IsVertex(v))
    {
      const Index corner = welded.Rings.RingCorners[static_cast<std::size_t>(welded.Rings.RingStart[v])];
      points.Places[p].Triangle = corner / 3;
      points.Places[p].Weights[corner % 3] = 1.0;
      points.Decoded.push_back(static_cast<std::uint32_t>(p));
    }
  }
  return points;
}

/// Returns the places of the points of a target on itself.
DecodedPlaces PlacesOfPoints(const TriangleMesh& target)
{
  DecodedPlaces points;
  points.Places.resize(static_cast<std::size_t>(target.NumberOfPoints()));
  for (Eigen::Index corner = target.Triangles.size() - 1; corner >= 0; --corner)
  {
    SurfacePlace& place = points.Places[static_cast<std::size_t>(target.Triangles.data()[corner])];
    place.Triangle = static_cast<Index>(corner / 3);
    place.Weights = Eigen::Vector3d::Unit(corner % 3);
  }
  for (std::size_t p = 0; p < points.Places.size(); ++p)
  {
    if (points.Places[p].Triangle >= 0)
    {
      points.Decoded.push_back(static_cast<std::uint32_t>(p));
    }
  }
  return points;
}

/// Replaces places on @p target by the nearest ones on another surface.
void MoveToNearest(
  const NearestPlaces& nearest, const TriangleMesh& target, DecodedPlaces& places, const Progress& progress)
{
  const std::size_t count = places.Decoded.size();
  for (std::size_t begin = 0; begin < count; begin += PlacesOfStep)
  {
    Report(progress, static_cast<double>(begin) / static_cast<double>(count));
    const std::size_t size = std::min(PlacesOfStep, count - begin);
    PointMatrix points(static_cast<Eigen::Index>(size), 3);
    for (std::size_t k = 0; k < size; ++k)
    {
      const SurfacePlace& place = places.Places[places.Decoded[begin + k]];
      const auto corners = target.Triangles.row(place.Triangle);
      points.row(static_cast<Eigen::Index>(k)) = place.Weights[0] * target.Points.row(corners[0]) +
        place.Weights[1] * target.Points.row(corners[1]) + place.Weights[2] * target.Points.row(corners[2]);
    }
    const std::vector<SurfacePlace> found = nearest.Find(points);
    for (std::size_t k = 0; k < size; ++k)
    {
      places.Places[places.Decoded[begin + k]] = found[k];
    }
  }
}

bool AreEqual(const AtlasRasterOptions& a, const AtlasRasterOptions& b)
{
  return a.Width == b.Width && a.Height == b.Height && a.GutterWidth == b.GutterWidth;
}
} // namespace

AtlasPlaces::AtlasPlaces(const WeldedSurface& source, const Surface& target, bool isSource,
  TextureCoordinates coordinates, const AtlasRasterOptions& options, const Progress& progress)
  : Coordinates(std::move(coordinates))
  , Options(options)
  , TargetHash(target.MeshHash())
  , OnSource(isSource)
{
  AtlasRaster raster = this->Rasterize(options, SubProgress(progress, 0.0, isSource ? 0.8 : 0.3));
  for (const AtlasFinding& finding : raster.Findings)
  {
    if (finding.Defect == AtlasDefect::OverlappingTriangles)
    {
      this->Warning = DescribeAtlasFindings({ finding }, [&target](std::int64_t f) { return target.Cell(f); }) +
        " vtkTextureAtlasFilter makes them.";
    }
  }
  this->Texels.Places = std::move(raster.Places);
  this->FindGutters(raster);
  OrderByTriangle(this->Texels);
  Report(progress, isSource ? 1.0 : 0.4);
  this->Points = isSource ? PlacesOfPoints(source) : PlacesOfPoints(target.Mesh);
  if (!isSource)
  {
    this->MoveToSource(source, target, SubProgress(progress, 0.4, 1.0));
  }
  OrderByTriangle(this->Points);
}

bool AtlasPlaces::Is(
  const Surface& target, bool isSource, const TextureCoordinates& coordinates, const AtlasRasterOptions& options) const
{
  return this->OnSource == isSource && AreEqual(this->Options, options) && this->TargetHash == target.MeshHash() &&
    this->Coordinates == coordinates;
}

AtlasRaster AtlasPlaces::Rasterize(const AtlasRasterOptions& options, const Progress& progress) const
{
  // A cancelled rasterization ends in the background: it owns what it touches.
  const auto coordinates = std::make_shared<const TextureCoordinates>(this->Coordinates);
  const auto raster = std::make_shared<AtlasRaster>();
  const double texels = static_cast<double>(options.Width) * options.Height;
  const int threads = MaximumThreads();
  RunCancellable(
    [coordinates, raster, options, threads] {
      const ThreadScope scope(threads);
      *raster = RasterizeAtlas(*coordinates, options);
    },
    0.01 + 5e-8 * texels + 1e-7 * static_cast<double>(coordinates->rows()), progress);
  return std::move(*raster);
}

/// Divides the texels into those to decode and gutters, which have the color of one of those.
void AtlasPlaces::FindGutters(const AtlasRaster& raster)
{
  const std::vector<SurfacePlace>& places = this->Texels.Places;
  std::unordered_map<std::uint64_t, std::uint32_t> sources;
  for (std::size_t t = 0; t < places.size(); ++t)
  {
    if (raster.Kinds[t] == TexelKind::Gutter || raster.Kinds[t] == TexelKind::Empty)
    {
      continue;
    }
    this->Texels.Decoded.push_back(static_cast<std::uint32_t>(t));
    if (IsAtGutter(raster, t))
    {
      sources.emplace(HashOf(places[t]), static_cast<std::uint32_t>(t));
    }
  }
  for (std::size_t t = 0; t < places.size(); ++t)
  {
    if (raster.Kinds[t] != TexelKind::Gutter)
    {
      continue;
    }
    const auto found = sources.find(HashOf(places[t]));
    if (found != sources.end() && AreEqual(places[found->second], places[t]))
    {
      this->Gutters.emplace_back(static_cast<std::uint32_t>(t), found->second);
    }
    else
    {
      this->Texels.Decoded.push_back(static_cast<std::uint32_t>(t)); // two places with one hash
    }
  }
}

void AtlasPlaces::MoveToSource(const WeldedSurface& source, const Surface& target, const Progress& progress)
{
  const TriangleMesh mesh = UsedPoints(source.Mesh).Compact(source.Mesh);
  const NearestPlaces nearest(mesh);
  MoveToNearest(nearest, target.Mesh, this->Texels, SubProgress(progress, 0.0, 0.9));
  MoveToNearest(nearest, target.Mesh, this->Points, SubProgress(progress, 0.9, 1.0));
  OrderByTriangle(this->Texels);
}

} // namespace surfsynth
