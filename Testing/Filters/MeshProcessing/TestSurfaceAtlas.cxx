// SPDX-License-Identifier: BSD-3-Clause
//
// Atlases of surfaces without texture coordinates: no overlaps, margins, stretch, density, any topology, repeatable.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Atlas/AtlasRaster.h"
#include "Core/Atlas/TextureSampling.h"
#include "Core/Common/Parallel.h"
#include "MeshProcessing/Atlas/ChartMaps.h"
#include "MeshProcessing/Atlas/SurfaceAtlas.h"
#include "MeshProcessing/Atlas/SurfaceCharts.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

using namespace surfsynth;
using namespace surfsynth::test;
using surfsynthtest::MessageOf;
using surfsynthtest::TextOf;
using ::testing::HasSubstr;

namespace
{
SurfaceAtlasOptions Sized(int width, int height, int margin = 4)
{
  SurfaceAtlasOptions options;
  options.Width = width;
  options.Height = height;
  options.Margin = margin;
  return options;
}

double AreaOf(const TriangleMesh& mesh, Index f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::RowVector3d a = mesh.Points.row(t(1)) - mesh.Points.row(t(0));
  const Eigen::RowVector3d b = mesh.Points.row(t(2)) - mesh.Points.row(t(0));
  return 0.5 * a.cross(b).norm();
}

double TextureArea(const TextureCoordinates& coordinates, Index f)
{
  const Eigen::RowVector2d a = coordinates.row(3 * f + 1) - coordinates.row(3 * f);
  const Eigen::RowVector2d b = coordinates.row(3 * f + 2) - coordinates.row(3 * f);
  return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

/// Least Chebyshev distance of covered texels of two different charts, at most @p limit.
int LeastDistance(const AtlasRaster& raster, const SurfaceAtlas& atlas, int limit)
{
  const auto chartOf = [&](int i, int j) {
    const std::int64_t texel = std::int64_t(j) * raster.Width + i;
    return raster.Kinds[texel] == TexelKind::Covered ? atlas.ChartOfTriangle[raster.Places[texel].Triangle] : -1;
  };
  for (int distance = 1; distance < limit; ++distance)
  {
    for (int j = 0; j + distance < raster.Height; ++j)
    {
      for (int i = distance; i + distance < raster.Width; ++i)
      {
        for (int k = -distance; k <= distance && chartOf(i, j) >= 0; ++k)
        {
          const int other = chartOf(i + k, j + distance);
          if (other >= 0 && other != chartOf(i, j))
          {
            return distance;
          }
        }
      }
    }
  }
  return limit;
}

/// Checks all that holds for every atlas.
void CheckAtlas(const TriangleMesh& mesh, const SurfaceAtlas& atlas, const SurfaceAtlasOptions& options)
{
  ASSERT_EQ(atlas.Coordinates.rows(), 3 * mesh.NumberOfTriangles());
  ASSERT_EQ(atlas.ChartOfTriangle.size(), static_cast<std::size_t>(mesh.NumberOfTriangles()));
  EXPECT_TRUE(CheckTextureCoordinates(atlas.Coordinates, mesh.NumberOfTriangles()).empty());
  const AtlasRaster raster = RasterizeAtlas(atlas.Coordinates, { options.Width, options.Height, 0 });
  EXPECT_TRUE(raster.Findings.empty()) << DescribeAtlasFindings(raster.Findings);
  EXPECT_GE(LeastDistance(raster, atlas, options.Margin), options.Margin);
  EXPECT_LE(atlas.LargestStretch, options.MaximumStretch);
  EXPECT_GE(atlas.RootMeanStretch, 1.0 - 1e-12);
  // The same density in all charts, and half of the margin at the sides.
  std::vector<double> area(static_cast<std::size_t>(atlas.NumberOfCharts), 0.0);
  std::vector<double> textureArea(area.size(), 0.0);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    area[atlas.ChartOfTriangle[f]] += AreaOf(mesh, f);
    textureArea[atlas.ChartOfTriangle[f]] += TextureArea(atlas.Coordinates, f) * options.Width * options.Height;
  }
  for (std::size_t k = 0; k < area.size(); ++k)
  {
    EXPECT_NEAR(textureArea[k] / area[k] / (atlas.TexelsPerLength * atlas.TexelsPerLength), 1.0, 1e-9);
  }
  const double sum = std::accumulate(textureArea.begin(), textureArea.end(), 0.0);
  EXPECT_NEAR(atlas.Coverage, sum / options.Width / options.Height, 1e-12);
  EXPECT_GE(atlas.Coordinates.col(0).minCoeff() * options.Width, 0.5 * options.Margin - 1e-9);
  EXPECT_LE(atlas.Coordinates.col(0).maxCoeff() * options.Width, options.Width - 0.5 * options.Margin + 1e-9);
  EXPECT_GE(atlas.Coordinates.col(1).minCoeff() * options.Height, 0.5 * options.Margin - 1e-9);
  EXPECT_LE(atlas.Coordinates.col(1).maxCoeff() * options.Height, options.Height - 0.5 * options.Margin + 1e-9);
}

SurfaceAtlas Checked(const TriangleMesh& mesh, const SurfaceAtlasOptions& options)
{
  SurfaceAtlas atlas = MakeSurfaceAtlas(mesh, options);
  CheckAtlas(mesh, atlas, options);
  return atlas;
}

/// A ring of eight cubes: genus 1, with sharp edges.
TriangleMesh RingOfCubes()
{
  std::set<UnitCube> cubes;
  for (int i = 0; i < 9; ++i)
  {
    if (i != 4)
    {
      cubes.insert({ i % 3, i / 3, 0 });
    }
  }
  return SurfaceOfCubes(cubes);
}
} // namespace

TEST(SurfaceAtlas, OfASphereHasFewChartsOfLittleStretch)
{
  const SurfaceAtlas atlas = Checked(Icosphere(3), Sized(512, 512));
  EXPECT_GE(atlas.NumberOfCharts, 2);
  EXPECT_LE(atlas.NumberOfCharts, 12);
  EXPECT_GE(atlas.Coverage, 0.4);
  EXPECT_LE(atlas.RootMeanStretch, 1.05);
  EXPECT_LE(atlas.LargestStretch, 1.5);
}

TEST(SurfaceAtlas, OfAPlaneIsOneChartWithoutStretch)
{
  TriangleMesh mesh = PlanePatch(12, 9, 2.0, 1.0, 0.2);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  mesh.Points = mesh.Points * turn.transpose();
  const SurfaceAtlas atlas = Checked(mesh, Sized(256, 512));
  EXPECT_EQ(atlas.NumberOfCharts, 1);
  EXPECT_NEAR(atlas.RootMeanStretch, 1.0, 1e-9);
  EXPECT_NEAR(atlas.LargestStretch, 1.0, 1e-6);
  EXPECT_GE(atlas.Coverage, 0.9); // its sides are as 2 : 1, like those of the image
}

TEST(SurfaceAtlas, OfDevelopableSurfacesIsWithoutStretch)
{
  const SurfaceAtlas atlas = Checked(OpenCylinder(24, 8), Sized(256, 256));
  EXPECT_NEAR(atlas.RootMeanStretch, 1.0, 1e-6);
}

TEST(SurfaceAtlas, TakesAnyTopology)
{
  Checked(Torus(24, 12), Sized(256, 256));
  Checked(RingOfCubes(), Sized(200, 300));
  Checked(SphereWithoutCap(3, 0.6), Sized(256, 256));
  Checked(Join(Join(Icosphere(2), Translated(Torus(16, 10), { 5, 0, 0 })), Translated(SingleTriangle(), { 9, 0, 0 })),
    Sized(512, 256, 2));
  Checked(Tetrahedron(), Sized(64, 64));
  EXPECT_EQ(Checked(SingleTriangle(), Sized(64, 64)).NumberOfCharts, 1);
  Checked(WithUnreferencedPoints(Icosphere(1)), Sized(128, 128));
}

TEST(SurfaceAtlas, BumpsAndIrregularTrianglesKeepTheBound)
{
  Checked(BumpySurface(3), Sized(512, 512));
  Checked(LocallyRefinedSphere(1), Sized(512, 512));
  SurfaceAtlasOptions strict = Sized(512, 512, 2);
  strict.MaximumStretch = 1.06;
  const SurfaceAtlas atlas = Checked(BumpySurface(3), strict);
  EXPECT_GT(atlas.NumberOfCharts, MakeSurfaceAtlas(BumpySurface(3), Sized(512, 512, 2)).NumberOfCharts);
}

TEST(SurfaceAtlas, OfFlatPlatesWithHolesHasFewCharts)
{
  // Normals do not say where to divide a plate.
  TriangleMesh plate = PlanePatch(24, 24, 1.0, 1.0, 0.2);
  TriangleMatrix kept(plate.Triangles.rows(), 3);
  Index count = 0;
  for (Index f = 0; f < plate.NumberOfTriangles(); ++f)
  {
    const auto t = plate.Triangles.row(f);
    const Eigen::RowVector3d center = (plate.Points.row(t(0)) + plate.Points.row(t(1)) + plate.Points.row(t(2))) / 3.0;
    const auto inHole = [&](double x, double y) { return (center.head<2>() - Eigen::RowVector2d(x, y)).norm() < 0.11; };
    if (!inHole(0.25, 0.25) && !inHole(0.7, 0.3) && !inHole(0.4, 0.7))
    {
      kept.row(count++) = t;
    }
  }
  plate.Triangles = kept.topRows(count);
  const SurfaceAtlas atlas = Checked(plate, Sized(256, 256));
  EXPECT_GE(atlas.NumberOfCharts, 2);
  EXPECT_LE(atlas.NumberOfCharts, 8);
  EXPECT_NEAR(atlas.RootMeanStretch, 1.0, 1e-6);
}

TEST(SurfaceAtlas, LargeImagesArePackedInCellsOfSeveralTexels)
{
  SurfaceAtlasOptions options = Sized(2100, 1300, 5);
  const SurfaceAtlas atlas = MakeSurfaceAtlas(Icosphere(2), options);
  CheckAtlas(Icosphere(2), atlas, options);
}

TEST(SurfaceAtlas, ATextureOfPositionsIsReadBack)
{
  const TriangleMesh mesh = BumpySurface(3);
  const SurfaceAtlas atlas = MakeSurfaceAtlas(mesh, Sized(400, 300));
  const AtlasRaster raster = RasterizeAtlas(atlas.Coordinates, { 400, 300, 2 });
  const auto at = [&](const SurfacePlace& place) {
    Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      point += place.Weights[k] * mesh.Points.row(mesh.Triangles(place.Triangle, k));
    }
    return point;
  };
  std::vector<float> image(3 * raster.Places.size(), 1e6F);
  for (std::size_t texel = 0; texel < raster.Places.size(); ++texel)
  {
    if (raster.Places[texel].Triangle >= 0)
    {
      Eigen::Map<Eigen::RowVector3f>(image.data() + 3 * texel) = at(raster.Places[texel]).cast<float>();
    }
  }
  // At most the size of a texel away, stretched ones included: look-ups beside seams see their own chart only.
  const double texel = 1.0 / atlas.TexelsPerLength;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (const Eigen::Vector3d& weights : { Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0.5, 0.5) })
    {
      const SurfacePlace place{ f, weights };
      Eigen::RowVector3f found;
      SampleTexture({ image.data(), 400, 300, 3 }, TextureWrap::Clamp, atlas.Coordinates, &place, 1, found.data());
      EXPECT_LE((found.cast<double>() - at(place)).norm(), 1.2 * texel);
    }
  }
}

TEST(SurfaceAtlas, DoesNotDependOnTheUnitOfLength)
{
  const TriangleMesh mesh = IrregularSphere(2);
  const SurfaceAtlas atlas = MakeSurfaceAtlas(mesh, Sized(256, 256));
  for (const double unit : { std::ldexp(1.0, 333), std::ldexp(1.0, -300) }) // about 1e100 and 1e-90
  {
    TriangleMesh other = mesh;
    other.Points *= unit;
    const SurfaceAtlas scaled = MakeSurfaceAtlas(other, Sized(256, 256));
    EXPECT_EQ(scaled.NumberOfCharts, atlas.NumberOfCharts);
    EXPECT_EQ(scaled.Coordinates, atlas.Coordinates);
    EXPECT_EQ(scaled.TexelsPerLength * unit, atlas.TexelsPerLength);
  }
}

TEST(SurfaceAtlas, HasTheSameBitsEachTime)
{
  const TriangleMesh mesh = BumpySurface(3);
  const SurfaceAtlas first = MakeSurfaceAtlas(mesh, Sized(256, 256));
  const ThreadScope scope(3);
  const SurfaceAtlas second = MakeSurfaceAtlas(mesh, Sized(256, 256));
  EXPECT_EQ(first.Coordinates, second.Coordinates);
  EXPECT_EQ(first.ChartOfTriangle, second.ChartOfTriangle);
}

TEST(SurfaceAtlas, WrongInputIsRefused)
{
  const TriangleMesh sphere = Icosphere(1);
  EXPECT_EQ(MakeSurfaceAtlas(TriangleMesh()).NumberOfCharts, 0);
  EXPECT_THAT(MessageOf([&] { MakeSurfaceAtlas(sphere, Sized(8, 64)); }), HasSubstr("8 x 64 texels; expected 16 to"));
  EXPECT_THAT(MessageOf([&] { MakeSurfaceAtlas(sphere, Sized(64, 64, 0)); }), HasSubstr("a margin of 0 texels"));
  EXPECT_THAT(MessageOf([&] { MakeSurfaceAtlas(sphere, Sized(32, 32, 100)); }), HasSubstr("do not fit into an image"));
  SurfaceAtlasOptions options;
  options.MaximumStretch = 1.0;
  EXPECT_THAT(MessageOf([&] { MakeSurfaceAtlas(sphere, options); }), HasSubstr("a maximum stretch of 1;"));
  EXPECT_THAT(MessageOf([&] { MakeSurfaceAtlas(MoebiusStrip(12, 3)); }), HasSubstr("wound in opposite senses"));
  EXPECT_THAT(MessageOf([&] {
    MakeSurfaceAtlas(SurfaceOfCubes({ { 0, 0, 0 }, { 1, 1, 0 } }));
  }),
    HasSubstr("non-manifold edge"));
  const std::atomic<bool> stop(true);
  EXPECT_THAT(TextOf<Cancelled>([&] { MakeSurfaceAtlas(sphere, {}, &stop); }), HasSubstr("cancelled"));
}

TEST(SurfaceCharts, APointWhereAChartTouchesItselfIsTwo)
{
  const TriangleMesh mesh = PlanePatch(4, 4);
  const MeshTopology topology(mesh);
  // Two triangles around the middle vertex that are not beside each other are left out.
  const Index middle = 2 * 5 + 2;
  std::vector<Index> around;
  std::vector<Index> kept;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const bool touches = (mesh.Triangles.row(f).array() == middle).any();
    (touches ? around : kept).push_back(f);
  }
  const auto sharesEdge = [&](Index f, Index g) {
    int common = 0;
    for (int k = 0; k < 3; ++k)
    {
      common += (mesh.Triangles.row(g).array() == mesh.Triangles(f, k)).any() ? 1 : 0;
    }
    return common == 2;
  };
  const auto apart = std::find_if(
    around.begin() + 1, around.end(), [&](Index f) { return !sharesEdge(around.front(), f); });
  ASSERT_NE(apart, around.end());
  std::copy_if(around.begin() + 1, around.end(), std::back_inserter(kept), [&](Index f) { return f != *apart; });
  std::sort(kept.begin(), kept.end());
  ChartCutter cutter(mesh, topology);
  ASSERT_EQ(cutter.ConnectedParts(kept).size(), 1U);
  const SurfaceChart pinched = cutter.Cut(kept);
  EXPECT_EQ(pinched.Mesh.NumberOfPoints(), mesh.NumberOfPoints() + 1);
  EXPECT_FALSE(pinched.IsDisk);
  std::vector<Index> all(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  std::iota(all.begin(), all.end(), 0);
  EXPECT_TRUE(cutter.Cut(all).IsDisk);
}

TEST(ChartMaps, ProjectionRefusesOverhangs)
{
  const auto cut = [](const TriangleMesh& mesh) { // without the points that no triangle uses
    std::vector<Index> all(static_cast<std::size_t>(mesh.NumberOfTriangles()));
    std::iota(all.begin(), all.end(), 0);
    return ChartCutter(mesh, MeshTopology(mesh)).Cut(all).Mesh;
  };
  const TriangleMesh half = cut(SphereWithoutCap(2, -0.3));
  const TriangleMesh most = cut(SphereWithoutCap(2, 0.3));
  EXPECT_GT(FlattenByProjection(half).rows(), 0);
  EXPECT_EQ(FlattenByProjection(most).rows(), 0);
  const FlatPoints flat = FlattenConformally(most);
  ASSERT_GT(flat.rows(), 0);
  EXPECT_GT(MeasureStretch(most, flat).Largest, 1.5);
}

TEST(ChartMaps, StretchIsThatOfALinearMap)
{
  const TriangleMesh mesh = PlanePatch(3, 3, 1.0, 1.0, 0.2);
  FlatPoints flat = mesh.Points.leftCols<2>();
  flat.col(0) *= 2.0;
  flat.col(1) *= 0.5;
  const ChartStretch stretch = MeasureStretch(mesh, flat);
  EXPECT_NEAR(stretch.Largest, 2.0, 1e-12);
  EXPECT_NEAR(stretch.SquaredStretch / stretch.Area, 0.5 * (4.0 + 0.25), 1e-12);
  EXPECT_NEAR(stretch.Area, 1.0, 1e-12);
}
