// SPDX-License-Identifier: BSD-3-Clause
// Rasterization of texture atlases and look-up of textures: exact places, common sides, thin triangles, gutters, defects.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Atlas/AtlasRaster.h"
#include "Core/Atlas/TextureSampling.h"
#include "Core/Common/Parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::HasSubstr;

namespace
{
/// The points of a plane mesh as texture coordinates.
TextureCoordinates FromPlane(const TriangleMesh& mesh)
{
  TextureCoordinates coordinates(3 * mesh.Triangles.rows(), 2);
  for (Eigen::Index c = 0; c < coordinates.rows(); ++c)
  {
    coordinates.row(c) = mesh.Points.row(mesh.Triangles(c / 3, c % 3)).head<2>();
  }
  return coordinates;
}

TextureCoordinates OneTriangle(double u0, double v0, double u1, double v1, double u2, double v2)
{
  TextureCoordinates coordinates(3, 2);
  coordinates << u0, v0, u1, v1, u2, v2;
  return coordinates;
}

TextureCoordinates Joined(const TextureCoordinates& a, const TextureCoordinates& b)
{
  TextureCoordinates joined(a.rows() + b.rows(), 2);
  joined << a, b;
  return joined;
}

Eigen::RowVector2d At(const TextureCoordinates& coordinates, const SurfacePlace& place)
{
  return place.Weights.transpose() * coordinates.middleRows<3>(3 * std::int64_t(place.Triangle));
}

std::int64_t CountOf(const AtlasRaster& raster, TexelKind kind)
{
  return std::count(raster.Kinds.begin(), raster.Kinds.end(), kind);
}

AtlasRaster Rasterized(const TextureCoordinates& coordinates, int width, int height, int gutter = 0)
{
  return RasterizeAtlas(coordinates, { width, height, gutter });
}

/// Two separate charts in the unit square: triangles of a grid of vertices each.
TextureCoordinates TwoCharts()
{
  TriangleMesh left = test::PlanePatch(5, 9, 0.38, 0.8, 0.2);
  left.Points.rowwise() += Eigen::RowVector3d(0.07, 0.1, 0.0);
  TriangleMesh right = test::PlanePatch(4, 3, 0.3, 0.5, 0.2);
  right.Points.rowwise() += Eigen::RowVector3d(0.6, 0.33, 0.0);
  return Joined(FromPlane(left), FromPlane(right));
}

/// Values of f(u, v) at the centers of texels, with @p channels multiples of it.
template <typename Function>
std::vector<float> Image(int width, int height, int channels, const Function& f)
{
  std::vector<float> values;
  for (int j = 0; j < height; ++j)
  {
    for (int i = 0; i < width; ++i)
    {
      for (int c = 0; c < channels; ++c)
      {
        values.push_back(static_cast<float>((c + 1) * f((i + 0.5) / width, (j + 0.5) / height)));
      }
    }
  }
  return values;
}
} // namespace

TEST(AtlasRaster, TexelsShowThePlacesOfTheirCenters)
{
  // Vertices of the second mesh lie on centers of texels, and sides pass through them.
  const TriangleMesh irregular = test::PlanePatch(7, 5, 1.0, 1.0, 0.2);
  TriangleMesh aligned = test::PlanePatch(10, 10, 1.0, 1.0);
  aligned.Points.array() += 1.0 / 80.0;
  for (const auto& [mesh, width, height] :
    { std::make_tuple(irregular, 97, 61), std::make_tuple(irregular, 3, 200), std::make_tuple(aligned, 40, 40) })
  {
    TextureCoordinates coordinates = FromPlane(mesh);
    coordinates = coordinates.cwiseMin(1.0);
    const AtlasRaster raster = Rasterized(coordinates, width, height);
    EXPECT_TRUE(std::all_of(raster.Findings.begin(), raster.Findings.end(),
      [](const AtlasFinding& finding) { return finding.Defect == AtlasDefect::DegenerateTriangle; }));
    EXPECT_EQ(CountOf(raster, TexelKind::Covered) + CountOf(raster, TexelKind::Border), std::int64_t(width) * height);
    EXPECT_GE(CountOf(raster, TexelKind::Covered), std::int64_t(width - 1) * (height - 1));
    for (int j = 0; j < height; ++j)
    {
      for (int i = 0; i < width; ++i)
      {
        const std::int64_t texel = j * width + i;
        if (raster.Kinds[texel] == TexelKind::Covered)
        {
          const SurfacePlace& place = raster.Places[texel];
          EXPECT_GE(place.Weights.minCoeff(), 0.0);
          EXPECT_NEAR(place.Weights.sum(), 1.0, 1e-14);
          const Eigen::RowVector2d center((i + 0.5) / width, (j + 0.5) / height);
          EXPECT_LE((At(coordinates, place) - center).norm(), 1e-7);
        }
      }
    }
  }
}

TEST(AtlasRaster, AHalfSquareHasHalfOfTheTexels)
{
  const AtlasRaster raster = Rasterized(OneTriangle(0, 0, 1, 0, 0, 1), 64, 64);
  EXPECT_EQ(CountOf(raster, TexelKind::Covered), 64 * 65 / 2); // those on the diagonal included
  EXPECT_EQ(raster.Kinds[0], TexelKind::Covered);              // row 0 is at v = 0
  EXPECT_EQ(raster.Kinds[64 * 64 - 1], TexelKind::Empty);
  EXPECT_LE((raster.Places[0].Weights - Eigen::Vector3d(126, 1, 1) / 128.0).norm(), 1e-14);
  EXPECT_EQ(raster.Kinds[64 * 63 + 1], TexelKind::Border);
  EXPECT_EQ(raster.Kinds[64 * 63 + 2], TexelKind::Empty); // sqrt(2) texels away
}

TEST(AtlasRaster, BilinearLookUpsInATriangleTouchNoEmptyTexel)
{
  // A needle thinner than a texel, a tiny triangle between centers, one without area, and ordinary charts.
  const TextureCoordinates coordinates = Joined(
    Joined(OneTriangle(0.02, 0.05, 0.98, 0.0503, 0.5, 0.0507), OneTriangle(0.5002, 0.95, 0.5004, 0.95, 0.5003, 0.9502)),
    Joined(OneTriangle(0.51, 0.92, 0.58, 0.99, 0.545, 0.955), TwoCharts()));
  const int size = 50;
  const AtlasRaster raster = Rasterized(coordinates, size, size);
  for (Index f = 0; f < coordinates.rows() / 3; ++f)
  {
    for (int s = 0; s < 200; ++s)
    {
      const double root = std::sqrt(0.5 + 0.5 * test::Uniform(f, 2 * s));
      const double share = 0.5 + 0.5 * test::Uniform(f, 2 * s + 1);
      const SurfacePlace place{ f, Eigen::Vector3d(1.0 - root, root * (1.0 - share), root * share) };
      const Eigen::RowVector2d position = (size * At(coordinates, place)).array() - 0.5;
      for (int k = 0; k < 4; ++k)
      {
        const auto i = static_cast<int>(std::clamp(std::floor(position.x()) + k % 2, 0.0, size - 1.0));
        const auto j = static_cast<int>(std::clamp(std::floor(position.y()) + k / 2, 0.0, size - 1.0));
        EXPECT_NE(raster.Kinds[j * size + i], TexelKind::Empty) << f << ' ' << i << ' ' << j;
      }
    }
  }
  ASSERT_EQ(raster.Findings.size(), 1U);
  EXPECT_EQ(raster.Findings[0].Defect, AtlasDefect::DegenerateTriangle);
  EXPECT_EQ(raster.Findings[0].First, 2);
}

TEST(AtlasRaster, ColorsOfChartsDoNotMix)
{
  const TextureCoordinates coordinates = TwoCharts();
  const Index firstOfRight = 2 * 5 * 9;
  const AtlasRaster raster = Rasterized(coordinates, 64, 48, 4);
  std::vector<float> image;
  std::transform(raster.Places.begin(), raster.Places.end(), std::back_inserter(image), [&](const SurfacePlace& place) {
    return place.Triangle < 0 ? -100.0F : (place.Triangle < firstOfRight ? 1.0F : 2.0F);
  });
  std::vector<SurfacePlace> places;
  for (Index f = 0; f < coordinates.rows() / 3; ++f)
  {
    places.push_back({ f, Eigen::Vector3d(1, 0, 0) });
    places.push_back({ f, Eigen::Vector3d(0, 0.5, 0.5) });
    places.push_back({ f, Eigen::Vector3d(0.3, 0.3, 0.4) });
  }
  std::vector<float> found(places.size());
  SampleTexture({ image.data(), 64, 48, 1 }, TextureWrap::Clamp, coordinates, places.data(),
    static_cast<std::int64_t>(places.size()), found.data());
  for (std::size_t q = 0; q < places.size(); ++q)
  {
    EXPECT_EQ(found[q], places[q].Triangle < firstOfRight ? 1.0F : 2.0F);
  }
}

TEST(AtlasRaster, BorderTexelsShowTheNearestPoint)
{
  const TextureCoordinates coordinates = OneTriangle(0.25, 0.25, 0.75, 0.25, 0.25, 0.75);
  const int size = 16; // the corner (4, 4) in texels
  const AtlasRaster raster = Rasterized(coordinates, size, size);
  // The texel (5, 3) with its center at (5.5, 3.5): half a texel below the lower side.
  EXPECT_EQ(raster.Kinds[3 * size + 5], TexelKind::Border);
  EXPECT_LE((At(coordinates, raster.Places[3 * size + 5]) - Eigen::RowVector2d(5.5, 4.0) / size).norm(), 1e-12);
  // The texel (3, 3): the corner.
  EXPECT_EQ(raster.Kinds[3 * size + 3], TexelKind::Border);
  EXPECT_LE((raster.Places[3 * size + 3].Weights - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(raster.Kinds[2 * size + 5], TexelKind::Empty);
}

TEST(AtlasRaster, GuttersShowTheNearestTexel)
{
  const int width = 40;
  const int height = 33;
  const AtlasRaster bare = Rasterized(TwoCharts(), width, height);
  for (const int gutter : { 1, 3, AtlasRasterOptions::WholeImage })
  {
    const AtlasRaster filled = Rasterized(TwoCharts(), width, height, gutter);
    for (int texel = 0; texel < width * height; ++texel)
    {
      if (bare.Kinds[texel] != TexelKind::Empty)
      {
        EXPECT_EQ(filled.Kinds[texel], bare.Kinds[texel]);
        EXPECT_EQ(filled.Places[texel].Weights, bare.Places[texel].Weights);
        continue;
      }
      int nearest = std::numeric_limits<int>::max();
      bool isOne = false;
      for (int other = 0; other < width * height; ++other)
      {
        const int across = other % width - texel % width;
        const int along = other / width - texel / width;
        const int distance = across * across + along * along;
        if (bare.Kinds[other] == TexelKind::Empty || distance > nearest)
        {
          continue;
        }
        const bool same = filled.Places[texel].Triangle == bare.Places[other].Triangle &&
          filled.Places[texel].Weights == bare.Places[other].Weights;
        isOne = same || (isOne && distance == nearest);
        nearest = distance;
      }
      const bool within = gutter < 0 || nearest <= gutter * gutter;
      EXPECT_EQ(filled.Kinds[texel], within ? TexelKind::Gutter : TexelKind::Empty);
      EXPECT_EQ(isOne, within) << texel;
    }
  }
}

TEST(AtlasRaster, OverlapsAreCountedOnceForEachTexel)
{
  // Two unit quarters that share a quarter of their area, three times.
  TriangleMesh square = test::PlanePatch(1, 1, 0.5, 0.5);
  const TextureCoordinates first = FromPlane(square);
  square.Points.rowwise() += Eigen::RowVector3d(0.25, 0.25, 0.0);
  const TextureCoordinates second = FromPlane(square);
  const AtlasRaster raster = Rasterized(Joined(Joined(first, second), second), 40, 40);
  ASSERT_EQ(raster.Findings.size(), 1U);
  EXPECT_EQ(raster.Findings[0].Defect, AtlasDefect::OverlappingTriangles);
  EXPECT_EQ(raster.Findings[0].Count, 400 - 20); // but for the centers on the diagonal of the second, seen below
  EXPECT_EQ(raster.Findings[0].First, 0);
  EXPECT_EQ(raster.Findings[0].Second, 2);
  EXPECT_THAT(DescribeAtlasFindings(raster.Findings, [](std::int64_t f) { return f + 10; }),
    HasSubstr("380 texel(s) that several cells share, first the cells 10 and 12"));
  EXPECT_TRUE(Rasterized(first, 40, 40).Findings.empty());
}

TEST(AtlasRaster, DefectsOfCoordinatesAreNamed)
{
  TextureCoordinates coordinates = TwoCharts();
  const auto count = coordinates.rows() / 3;
  EXPECT_TRUE(CheckTextureCoordinates(coordinates, count).empty());
  EXPECT_THAT(
    MessageOf([&] { CheckTextureCoordinates(coordinates, count + 1); }), HasSubstr("three for each triangle"));
  EXPECT_THAT(
    MessageOf([&] { RasterizeAtlas(TextureCoordinates::Zero(4, 2)); }), HasSubstr("coordinates of 4 corners"));
  coordinates.row(3 * 7).swap(coordinates.row(3 * 7 + 1));
  coordinates.row(3 * 9 + 2) = coordinates.row(3 * 9 + 1);
  std::vector<AtlasFinding> findings = CheckTextureCoordinates(coordinates, count);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].Defect, AtlasDefect::DegenerateTriangle);
  EXPECT_EQ(findings[0].First, 9);
  EXPECT_EQ(findings[1].Defect, AtlasDefect::FlippedTriangle);
  EXPECT_EQ(findings[1].First, 7);
  EXPECT_EQ(findings[1].Count, 1);
  // The atlas as a whole may be mirrored.
  TextureCoordinates mirrored = TwoCharts();
  mirrored.col(0) = 1.0 - mirrored.col(0).array();
  EXPECT_TRUE(CheckTextureCoordinates(mirrored, count).empty());
  EXPECT_EQ(CountOf(Rasterized(mirrored, 64, 64), TexelKind::Covered),
    CountOf(Rasterized(TwoCharts(), 64, 64), TexelKind::Covered));
  coordinates(3 * 20 + 1, 0) = 1.5;
  EXPECT_THAT(MessageOf([&] { RasterizeAtlas(coordinates); }),
    HasSubstr("1 cell(s) with texture coordinates outside [0, 1], first cell 20"));
  coordinates(3 * 21 + 1, 1) = std::nan("");
  EXPECT_THAT(
    MessageOf([&] { RasterizeAtlas(coordinates); }), HasSubstr("NaN or infinite texture coordinate, first cell 21"));
  EXPECT_THAT(DescribeAtlasFindings(CheckTextureCoordinates(coordinates, count)), HasSubstr("Also 1 cell(s) with"));
}

TEST(AtlasRaster, SizesOutOfRangeAreRefused)
{
  const TextureCoordinates coordinates = TwoCharts();
  EXPECT_THAT(MessageOf([&] { Rasterized(coordinates, 0, 5); }), HasSubstr("0 x 5 texels; expected 1 to 32768"));
  EXPECT_THAT(MessageOf([&] { Rasterized(coordinates, 5, 40000); }), HasSubstr("5 x 40000 texels"));
  EXPECT_THAT(MessageOf([&] { Rasterized(coordinates, 5, 5, -2); }), HasSubstr("a gutter of -2 texels"));
  EXPECT_THAT(MessageOf([&] { Rasterized(coordinates, 32768, 32768); }), HasSubstr("texels fit"));
}

TEST(AtlasRaster, NoTrianglesShowNothing)
{
  const AtlasRaster raster = Rasterized(TextureCoordinates(0, 2), 5, 4, AtlasRasterOptions::WholeImage);
  EXPECT_EQ(CountOf(raster, TexelKind::Empty), 20);
  EXPECT_TRUE(raster.Findings.empty());
  EXPECT_EQ(Rasterized(TwoCharts(), 1, 1).Places.size(), 1U);
}

TEST(AtlasRaster, RingsCountTheirTexels)
{
  const TriangleMesh mesh = test::PlanePatch(4, 4);
  const AtlasRaster raster = Rasterized(FromPlane(mesh), 64, 64, 2);
  const std::vector<std::int64_t> counts = CountRingTexels(raster, mesh.Triangles, mesh.NumberOfPoints());
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::int64_t(0)), 3 * 64 * 64);
  // The middle vertex has eight triangles of half a cell of 16 x 16 texels; those on diagonals belong to one of two.
  EXPECT_EQ((mesh.Triangles.array() == 2 * 5 + 2).count(), 8);
  EXPECT_NEAR(static_cast<double>(counts[2 * 5 + 2]), 8 * 128.0, 4 * 16.0);
  EXPECT_THAT(
    MessageOf([&] { CountRingTexels(raster, mesh.Triangles.topRows(3), 25); }), HasSubstr("expected an id in"));
}

TEST(AtlasRaster, IsTheSameForEveryNumberOfThreads)
{
  const TextureCoordinates coordinates = Joined(TwoCharts(), OneTriangle(0.1, 0.2, 0.9, 0.4, 0.5, 0.6));
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    return Rasterized(coordinates, 128, 128, 5);
  };
  const AtlasRaster one = with(1);
  for (const int threads : { 2, 3, 7 })
  {
    const AtlasRaster other = with(threads);
    EXPECT_EQ(one.Kinds, other.Kinds);
    for (std::size_t texel = 0; texel < one.Places.size(); ++texel)
    {
      ASSERT_EQ(one.Places[texel].Triangle, other.Places[texel].Triangle);
      ASSERT_EQ(one.Places[texel].Weights, other.Places[texel].Weights);
    }
    ASSERT_EQ(one.Findings.size(), other.Findings.size());
    EXPECT_EQ(one.Findings.back().Count, other.Findings.back().Count);
    EXPECT_EQ(one.Findings.back().Second, other.Findings.back().Second);
  }
}

TEST(TextureSampling, LinearFunctionsAreExactBetweenTheCenters)
{
  const TextureCoordinates coordinates = TwoCharts();
  const auto f = [](double u, double v) { return 0.25 + 2.0 * u - 3.0 * v; };
  for (const int channels : { 1, 2, 3, 4 })
  {
    const std::vector<float> image = Image(31, 17, channels, f);
    for (Index t = 0; t < coordinates.rows() / 3; ++t)
    {
      const SurfacePlace place{ t, Eigen::Vector3d(0.2, 0.3, 0.5) };
      float found[4];
      SampleTexture({ image.data(), 31, 17, channels }, TextureWrap::Clamp, coordinates, &place, 1, found);
      const Eigen::RowVector2d at = At(coordinates, place);
      for (int c = 0; c < channels; ++c)
      {
        EXPECT_NEAR(found[c], (c + 1) * f(at.x(), at.y()), 1e-5 * (c + 1));
      }
    }
  }
}

TEST(TextureSampling, WrapsAsAskedFor)
{
  const std::vector<float> image = { 1.0F, 2.0F, 4.0F, 8.0F }; // two by two, row 0 below
  const auto look = [&](double u, double v, TextureWrap wrap) {
    const TextureCoordinates coordinates = OneTriangle(u, v, u, v, u, v);
    const SurfacePlace place{ 0, Eigen::Vector3d(1, 0, 0) };
    float found = 0.0F;
    SampleTexture({ image.data(), 2, 2, 1 }, wrap, coordinates, &place, 1, &found);
    return found;
  };
  for (const TextureWrap wrap : { TextureWrap::Clamp, TextureWrap::Repeat })
  {
    EXPECT_EQ(look(0.25, 0.25, wrap), 1.0F);
    EXPECT_EQ(look(0.75, 0.25, wrap), 2.0F);
    EXPECT_EQ(look(0.25, 0.75, wrap), 4.0F);
    EXPECT_EQ(look(0.5, 0.5, wrap), 3.75F);
  }
  EXPECT_EQ(look(-3.0, 0.25, TextureWrap::Clamp), 1.0F);
  EXPECT_EQ(look(7.0, 9.0, TextureWrap::Clamp), 8.0F);
  EXPECT_EQ(look(0.0, 0.25, TextureWrap::Repeat), 1.5F);
  EXPECT_EQ(look(3.25, -1.75, TextureWrap::Repeat), 1.0F);
  EXPECT_EQ(look(1e300, 0.25, TextureWrap::Repeat), 1.5F);
  EXPECT_EQ(look(-0.75, 0.75, TextureWrap::Repeat), 4.0F);
}

TEST(TextureSampling, WrongInputIsRefused)
{
  const std::vector<float> image(4, 0.0F);
  TextureCoordinates coordinates = OneTriangle(0, 0, 1, 0, 0, 1);
  const auto look = [&](Index triangle, int channels) {
    const SurfacePlace place{ triangle, Eigen::Vector3d(0.5, 0.5, 0.0) };
    float found[4] = { 7.0F, 7.0F, 7.0F, 7.0F };
    SampleTexture({ image.data(), 2, 2, channels }, TextureWrap::Clamp, coordinates, &place, 1, found);
    return found[0];
  };
  EXPECT_EQ(look(-1, 1), 0.0F);
  EXPECT_THAT(MessageOf([&] { look(1, 1); }), HasSubstr("lies in triangle 1"));
  EXPECT_THAT(MessageOf([&] { look(0, 5); }), HasSubstr("with 5 channels"));
  EXPECT_THAT(MessageOf([&] { look(0, 0); }), HasSubstr("with 0 channels"));
  coordinates(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(MessageOf([&] { look(0, 1); }), HasSubstr("are not finite"));
}
