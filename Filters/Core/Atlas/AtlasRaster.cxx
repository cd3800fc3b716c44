// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/AtlasRaster.h"

#include "Core/Atlas/GutterFill.h"
#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr int LargestSize = 32768;
constexpr std::uint64_t BytesOfTexel = 41;
constexpr std::uint64_t MostTexels = std::uint64_t(1) << 28;
/// Least rows of a range.
constexpr std::int64_t RowGrain = 16;
/// Distances in texels: within the first, a center on a side belongs to both triangles; beyond the second, a center lies
/// inside.
constexpr double OnSide = 1e-6;
constexpr double InsideBy = 1e-3;
/// Reach of a bilinear look-up: the diagonal of a texel.
constexpr double Reach = 1.41421356237309505;

void RequireSize(const AtlasRasterOptions& options)
{
  const auto inRange = [](int size) { return size >= 1 && size <= LargestSize; };
  const std::string size = std::to_string(options.Width) + " x " + std::to_string(options.Height);
  if (!inRange(options.Width) || !inRange(options.Height))
  {
    throw InvalidInput("RasterizeAtlas: an image of " + size + " texels; expected 1 to " + std::to_string(LargestSize) +
      " along each axis.");
  }
  if (options.GutterWidth < AtlasRasterOptions::WholeImage)
  {
    throw InvalidInput("RasterizeAtlas: a gutter of " + std::to_string(options.GutterWidth) +
      " texels; expected 0 or more, or -1 for the whole image.");
  }
  const std::uint64_t bytes = BytesOfTexel * options.Width * options.Height;
  const std::uint64_t available = std::min(AvailableMemory(), BytesOfTexel * MostTexels);
  if (bytes > available)
  {
    const double factor = std::sqrt(static_cast<double>(available) / static_cast<double>(bytes));
    throw InvalidInput("RasterizeAtlas: an image of " + size + " texels takes " + std::to_string(bytes >> 20) +
      " MiB; " + std::to_string(available >> 20) + " MiB are allowed or available. " +
      std::to_string(int(factor * options.Width)) + " x " + std::to_string(int(factor * options.Height)) +
      " texels fit.");
  }
}

/// A triangle in the units of texels: the center of texel (i, j) is the point (i, j).
struct TexelTriangle
{
  TexelTriangle(const TextureCoordinates& coordinates, std::int64_t f, int width, int height)
  {
    for (int k = 0; k < 3; ++k)
    {
      this->Corner[k] = { coordinates(3 * f + k, 0) * width - 0.5, coordinates(3 * f + k, 1) * height - 0.5 };
    }
    const Eigen::Vector2d a = this->Corner[1] - this->Corner[0];
    const Eigen::Vector2d b = this->Corner[2] - this->Corner[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    const double longest = std::max({ a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm() });
    this->IsDegenerate = !(std::abs(area) > 2e-12 * longest);
    this->DoubleArea = std::abs(area);
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::Vector2d along = this->Corner[(k + 2) % 3] - this->Corner[(k + 1) % 3];
      this->Length[k] = along.norm();
      this->Inward[k] = (area < 0.0 ? -1.0 : 1.0) * Eigen::Vector2d(-along.y(), along.x());
    }
  }

  /// Distance of a point from the side opposite to corner @p k, inwards, times the length of the side: its barycentric
  /// coordinate times DoubleArea.
  double FromSide(int k, double x, double y) const
  {
    const Eigen::Vector2d& on = this->Corner[(k + 1) % 3];
    return this->Inward[k].x() * (x - on.x()) + this->Inward[k].y() * (y - on.y());
  }

  /// Least distance from the sides, inwards, texels.
  double Depth(double x, double y) const
  {
    double depth = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k)
    {
      depth = std::min(depth, this->FromSide(k, x, y) / this->Length[k]);
    }
    return depth;
  }

  double Lowest(int axis) const { return std::min({ Corner[0][axis], Corner[1][axis], Corner[2][axis] }); }
  double Highest(int axis) const { return std::max({ Corner[0][axis], Corner[1][axis], Corner[2][axis] }); }

  /// The columns of row @p row whose centers may be nearer to the triangle than @p distance; empty when first > second.
  std::pair<double, double> Columns(double row, double distance) const
  {
    double first = this->Lowest(0) - distance;
    double last = this->Highest(0) + distance;
    for (int k = 0; k < 3; ++k)
    {
      const double slope = this->Inward[k].x();
      const double atZero = this->FromSide(k, 0.0, row) + distance * this->Length[k];
      if (slope > 0.0)
      {
        first = std::max(first, -atZero / slope);
      }
      else if (slope < 0.0)
      {
        last = std::min(last, -atZero / slope);
      }
      else if (atZero < 0.0)
      {
        return { 1.0, 0.0 };
      }
    }
    return { std::ceil(first), std::floor(last) };
  }

  /// Calls visit(i, j) for the texels of the rows [@p begin, @p end) whose centers may be nearer than @p distance.
  template <typename Visit>
  void ForTexels(int width, std::int64_t begin, std::int64_t end, double distance, const Visit& visit) const
  {
    const auto firstRow = static_cast<std::int64_t>(
      std::clamp(std::ceil(this->Lowest(1) - distance), double(begin), double(end)));
    const auto lastRow = static_cast<std::int64_t>(
      std::clamp(std::floor(this->Highest(1) + distance), double(begin) - 1.0, double(end) - 1.0));
    for (std::int64_t j = firstRow; j <= lastRow; ++j)
    {
      const auto [first, last] = this->Columns(static_cast<double>(j), distance);
      const auto stop = static_cast<std::int64_t>(std::min(last, width - 1.0));
      for (auto i = static_cast<std::int64_t>(std::max(first, 0.0)); i <= stop; ++i)
      {
        visit(i, j);
      }
    }
  }

  Eigen::Vector2d Corner[3];
  Eigen::Vector2d Inward[3]; ///< normal of the side opposite to each corner, as long as the side
  double Length[3];
  double DoubleArea = 0.0;
  bool IsDegenerate = false;
};

/// Barycentric coordinates of the point of a triangle that is nearest to @p point, and its squared distance.
std::pair<Eigen::Vector3d, double> NearestPoint(const TexelTriangle& triangle, const Eigen::Vector2d& point)
{
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Vector2d& from = triangle.Corner[k];
    const Eigen::Vector2d side = triangle.Corner[(k + 1) % 3] - from;
    const double length = side.squaredNorm();
    const double along = length > 0.0 ? std::clamp(side.dot(point - from) / length, 0.0, 1.0) : 0.0;
    const double distance = (point - from - along * side).squaredNorm();
    if (distance < least)
    {
      least = distance;
      best.setZero();
      best[k] = 1.0 - along;
      best[(k + 1) % 3] = along;
    }
  }
  return { best, least };
}

/// Writes the rows of an atlas, all triangles into each range of rows.
class RowRasterizer
{
public:
  RowRasterizer(const TextureCoordinates& coordinates, AtlasRaster& raster)
    : Coordinates(coordinates)
    , Raster(raster)
    , Distances(raster.Places.size())
  {}

  void Rasterize(std::int64_t begin, std::int64_t end)
  {
    std::fill(this->Distances.data() + begin * this->Raster.Width, this->Distances.data() + end * this->Raster.Width,
      std::numeric_limits<float>::infinity());
    AtlasFinding overlaps{ AtlasDefect::OverlappingTriangles };
    this->ForTriangles(begin, end, OnSide, [&](const TexelTriangle& triangle, Index f) {
      if (!triangle.IsDegenerate)
      {
        triangle.ForTexels(this->Raster.Width, begin, end, OnSide,
          [&](std::int64_t i, std::int64_t j) { this->Cover(triangle, f, i, j, overlaps); });
      }
    });
    this->ForTriangles(begin, end, Reach, [&](const TexelTriangle& triangle, Index f) {
      triangle.ForTexels(
        this->Raster.Width, begin, end, Reach, [&](std::int64_t i, std::int64_t j) { this->Touch(triangle, f, i, j); });
    });
    this->Merge(overlaps);
  }

  AtlasFinding Overlaps{ AtlasDefect::OverlappingTriangles };

private:
  /// Calls visit(triangle, id) for the triangles nearer than @p distance to the rows [@p begin, @p end), ascending.
  template <typename Visit>
  void ForTriangles(std::int64_t begin, std::int64_t end, double distance, const Visit& visit)
  {
    const double lowest = (static_cast<double>(begin) - distance) / this->Raster.Height;
    const double highest = (static_cast<double>(end) + distance) / this->Raster.Height;
    const auto triangles = static_cast<Index>(this->Coordinates.rows() / 3);
    for (Index f = 0; f < triangles; ++f)
    {
      const auto v = this->Coordinates.middleRows<3>(3 * std::int64_t(f)).col(1);
      if (v.maxCoeff() >= lowest && v.minCoeff() <= highest)
      {
        visit(TexelTriangle(this->Coordinates, f, this->Raster.Width, this->Raster.Height), f);
      }
    }
  }

  void Cover(const TexelTriangle& triangle, Index f, std::int64_t i, std::int64_t j, AtlasFinding& overlaps)
  {
    const std::int64_t texel = j * this->Raster.Width + i;
    SurfacePlace& place = this->Raster.Places[texel];
    const auto x = static_cast<double>(i);
    const auto y = static_cast<double>(j);
    if (place.Triangle >= 0)
    {
      const TexelTriangle owner(this->Coordinates, place.Triangle, this->Raster.Width, this->Raster.Height);
      if (triangle.Depth(x, y) > InsideBy && owner.Depth(x, y) > InsideBy)
      {
        overlaps.Count += this->Raster.Kinds[texel] == TexelKind::Covered ? 1 : 0;
        this->Raster.Kinds[texel] = TexelKind::Overlapped;
        NoteOverlap(place.Triangle, f, overlaps);
      }
      return;
    }
    place.Triangle = f;
    for (int k = 0; k < 3; ++k)
    {
      place.Weights[k] = std::max(0.0, triangle.FromSide(k, x, y) / triangle.DoubleArea);
    }
    place.Weights /= place.Weights.sum();
    this->Raster.Kinds[texel] = TexelKind::Covered;
  }

  void Touch(const TexelTriangle& triangle, Index f, std::int64_t i, std::int64_t j)
  {
    const std::int64_t texel = j * this->Raster.Width + i;
    if (this->Raster.Kinds[texel] == TexelKind::Covered || this->Raster.Kinds[texel] == TexelKind::Overlapped)
    {
      return;
    }
    const auto [weights, distance] = NearestPoint(triangle, { static_cast<double>(i), static_cast<double>(j) });
    const auto nearer = static_cast<float>(distance);
    if (nearer < static_cast<float>(Reach * Reach) && nearer < this->Distances[texel])
    {
      this->Distances[texel] = nearer;
      this->Raster.Places[texel] = { f, weights };
      this->Raster.Kinds[texel] = TexelKind::Border;
    }
  }

  static void NoteOverlap(std::int64_t first, std::int64_t second, AtlasFinding& overlaps)
  {
    const std::pair<std::int64_t, std::int64_t> pair(first, second);
    if (overlaps.Second < 0 || pair < std::make_pair(overlaps.First, overlaps.Second))
    {
      overlaps.First = first;
      overlaps.Second = second;
    }
  }

  void Merge(const AtlasFinding& overlaps)
  {
    if (overlaps.Count > 0)
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      this->Overlaps.Count += overlaps.Count;
      NoteOverlap(overlaps.First, overlaps.Second, this->Overlaps);
    }
  }

  const TextureCoordinates& Coordinates;
  AtlasRaster& Raster;
  LargeArray<float> Distances; ///< squared, of border texels
  std::mutex Mutex;
};
} // namespace

AtlasRaster RasterizeAtlas(const TextureCoordinates& coordinates, const AtlasRasterOptions& options)
{
  RequireSize(options);
  AtlasRaster raster;
  for (const AtlasFinding& finding : CheckTextureCoordinates(coordinates, coordinates.rows() / 3))
  {
    if (finding.Defect == AtlasDefect::NonFiniteCoordinate || finding.Defect == AtlasDefect::OutsideUnitSquare)
    {
      throw InvalidInput("RasterizeAtlas: " + DescribeAtlasFindings({ finding }));
    }
    raster.Findings.push_back(finding);
  }
  raster.Width = options.Width;
  raster.Height = options.Height;
  raster.Places.resize(static_cast<std::size_t>(options.Width) * options.Height);
  raster.Kinds.assign(raster.Places.size(), TexelKind::Empty);
  {
    RowRasterizer rows(coordinates, raster);
    ParallelFor(options.Height, RowGrain, [&](std::int64_t begin, std::int64_t end) { rows.Rasterize(begin, end); });
    if (rows.Overlaps.Count > 0)
    {
      raster.Findings.push_back(rows.Overlaps);
    }
  }
  if (options.GutterWidth != 0)
  {
    FillGutter(raster, options.GutterWidth);
  }
  return raster;
}

std::vector<std::int64_t> CountRingTexels(
  const AtlasRaster& raster, const TriangleMatrix& triangles, Index numberOfPoints)
{
  std::vector<std::int64_t> ofTriangle(static_cast<std::size_t>(triangles.rows()), 0);
  for (std::size_t texel = 0; texel < raster.Places.size(); ++texel)
  {
    const bool counts = raster.Kinds[texel] == TexelKind::Covered || raster.Kinds[texel] == TexelKind::Overlapped;
    const Index f = raster.Places[texel].Triangle;
    if (counts && f >= triangles.rows())
    {
      throw InvalidInput("CountRingTexels: texel " + std::to_string(texel) + " shows triangle " + std::to_string(f) +
        "; expected an id in [0, " + std::to_string(triangles.rows()) + ").");
    }
    if (counts)
    {
      ++ofTriangle[f];
    }
  }
  std::vector<std::int64_t> ofPoint(static_cast<std::size_t>(numberOfPoints), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      ofPoint[triangles(f, k)] += ofTriangle[f];
    }
  }
  return ofPoint;
}

} // namespace surfsynth
