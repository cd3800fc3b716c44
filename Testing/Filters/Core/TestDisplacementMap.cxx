// SPDX-License-Identifier: BSD-3-Clause
//
// Displacement and height maps: closed forms, correspondence by index and along normals, frames, seams, round trips.
#include "ExampleMeshes.h"

#include "Core/Atlas/DisplacementMap.h"
#include "Core/Atlas/SurfaceFrames.h"
#include "Core/Atlas/TextureSampling.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Mesh/SubdivisionPlaces.h"
#include "Core/Mesh/WeldedPoints.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
/// Texture coordinates with two triangles in each cell of a grid, apart from each other: all edges are seams.
TextureCoordinates TriangleGrid(Index triangles)
{
  const int cells = static_cast<int>(std::ceil(std::sqrt((triangles + 1) / 2)));
  TextureCoordinates coordinates(3 * triangles, 2);
  constexpr double corners[2][3][2] = { { { 0.1, 0.06 }, { 0.94, 0.06 }, { 0.94, 0.9 } },
    { { 0.06, 0.1 }, { 0.9, 0.94 }, { 0.06, 0.94 } } };
  for (Index f = 0; f < triangles; ++f)
  {
    const int cell = f / 2;
    for (int k = 0; k < 3; ++k)
    {
      coordinates.row(3 * f + k) << (cell % cells + corners[f % 2][k][0]) / cells,
        (cell / cells + corners[f % 2][k][1]) / cells;
    }
  }
  return coordinates;
}

/// Texture coordinates of all corners from the places of points.
TextureCoordinates CoordinatesBy(
  const TriangleMesh& mesh, const std::function<Eigen::RowVector2d(const Eigen::RowVector3d&)>& place)
{
  TextureCoordinates coordinates(3 * mesh.NumberOfTriangles(), 2);
  for (Eigen::Index corner = 0; corner < coordinates.rows(); ++corner)
  {
    coordinates.row(corner) = place(mesh.Points.row(mesh.Triangles.data()[corner]));
  }
  return coordinates;
}

TextureCoordinates PlaneCoordinates(const TriangleMesh& mesh)
{
  return CoordinatesBy(mesh, [](const Eigen::RowVector3d& x) { return Eigen::RowVector2d(x[0], x[1]); });
}

TriangleMesh Subdivided(TriangleMesh mesh, int levels)
{
  for (int level = 0; level < levels; ++level)
  {
    mesh = SubdivideAtMidpoints(mesh).Mesh;
  }
  return mesh;
}

/// The mesh with points of its own for each triangle.
TriangleMesh TakenApart(const TriangleMesh& mesh)
{
  TriangleMesh soup{ PointMatrix(mesh.Triangles.size(), 3), mesh.Triangles };
  for (Eigen::Index corner = 0; corner < mesh.Triangles.size(); ++corner)
  {
    soup.Points.row(corner) = mesh.Points.row(mesh.Triangles.data()[corner]);
    soup.Triangles.data()[corner] = static_cast<Index>(corner);
  }
  return soup;
}

DisplacementMapOptions OptionsOf(int size, bool byIndex = true)
{
  DisplacementMapOptions options;
  options.Raster.Width = options.Raster.Height = size;
  options.ByIndex = byIndex;
  return options;
}

/// Calls @p check with the number and place of each covered texel.
void ForCovered(const DisplacementMap& map, const TextureCoordinates& coordinates, int size,
  const std::function<void(std::size_t, const SurfacePlace&)>& check)
{
  AtlasRasterOptions options;
  options.Width = options.Height = size;
  const AtlasRaster raster = RasterizeAtlas(coordinates, options);
  std::size_t covered = 0;
  for (std::size_t t = 0; t < map.Coverage.size(); ++t)
  {
    if (map.Coverage[t] == 255)
    {
      check(t, raster.Places[t]);
      ++covered;
    }
  }
  EXPECT_EQ(covered, static_cast<std::size_t>(map.CoveredTexels));
  EXPECT_GT(covered, map.Coverage.size() / 4);
}

Eigen::Vector3d VectorAt(const DisplacementMap& map, std::size_t t)
{
  return { map.Displacements[3 * t], map.Displacements[3 * t + 1], map.Displacements[3 * t + 2] };
}

/// Bumps that lean over: points above the plain surface move aside, too.
TriangleMesh WithLeaningBumps(TriangleMesh mesh)
{
  for (Eigen::Index p = 0; p < mesh.Points.rows(); ++p)
  {
    const Eigen::RowVector3d x = mesh.Points.row(p);
    const double height = 0.05 * (1.0 + std::sin(9.0 * x[0]) * std::sin(9.0 * x[1]) * std::sin(9.0 * x[2]));
    mesh.Points.row(p) += height * x + 0.5 * height * Eigen::RowVector3d(-x[1], x[0], 0.0);
  }
  return mesh;
}
} // namespace

TEST(SubdivisionPlaces, AreTheSamePlacesBeforePointsMove)
{
  const TriangleMesh mesh = BumpySurface(1);
  for (int levels = 0; levels <= 3; ++levels)
  {
    const TriangleMesh fine = Subdivided(mesh, levels);
    for (const bool isSoup : { false, true })
    {
      const TriangleMesh plain = isSoup ? TakenApart(mesh) : mesh;
      const auto places = SubdivisionPlaces::Find(plain, WeldPoints(plain), fine);
      ASSERT_TRUE(places) << levels;
      EXPECT_EQ(places->NumberOfLevels(), levels);
      for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
      {
        const double u = 0.5 * (1.0 + Uniform(1, f)), v = (1.0 - u) * 0.5 * (1.0 + Uniform(2, f));
        const SurfacePlace place{ f, { u, v, 1.0 - u - v } };
        EXPECT_LT((PositionOf(plain, place) - PositionOf(fine, places->OnSubdivision(place))).norm(), 1e-14);
      }
    }
  }
}

TEST(SubdivisionPlaces, AreNotFoundOnOtherMeshes)
{
  const TriangleMesh mesh = BumpySurface(1);
  const std::vector<Index> classes = WeldPoints(mesh);
  const auto isFound = [&](const TriangleMesh& other) {
    return SubdivisionPlaces::Find(mesh, classes, other).has_value();
  };
  TriangleMesh fine = Subdivided(mesh, 2);
  EXPECT_TRUE(isFound(fine));
  fine.Triangles.row(3).swap(fine.Triangles.row(100));
  EXPECT_FALSE(isFound(fine)) << "another order of triangles";
  EXPECT_FALSE(isFound(BumpySurface(2))) << "as many triangles in another order";
  TriangleMesh turned = Subdivided(mesh, 1);
  turned.Triangles.row(5) << turned.Triangles(5, 1), turned.Triangles(5, 2), turned.Triangles(5, 0);
  EXPECT_FALSE(isFound(turned)) << "another first corner";
  EXPECT_FALSE(isFound(Icosphere(0))) << "another number of triangles";
  TriangleMesh mirrored = mesh;
  mirrored.Triangles.row(0).swap(mirrored.Triangles.row(1));
  EXPECT_FALSE(isFound(mirrored)) << "no subdivision, two triangles exchanged";
}

TEST(DisplacementMap, LargerSphereHasOneHeight)
{
  const TriangleMesh plain = Icosphere(3);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const TriangleMesh detailed = UvSphere(150, 300, 1.1);
  const DisplacementMap map = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(512));
  EXPECT_EQ(map.SubdivisionLevels, -1);
  EXPECT_EQ(map.Misses, 0);
  ForCovered(map, coordinates, 512, [&](std::size_t t, const SurfacePlace& place) {
    // Places of triangles lie below the unit sphere; interpolated normals are radial to 0.02.
    const double expected = 1.1 - PositionOf(plain, place).norm();
    EXPECT_NEAR(map.Heights[t], expected, 2e-4);
    EXPECT_NEAR(VectorAt(map, t).norm(), map.Heights[t], 1e-6) << "along the normal";
  });
}

TEST(DisplacementMap, SmallerSphereHasNegativeHeights)
{
  const TriangleMesh plain = Icosphere(3);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const DisplacementMap map = BakeDisplacementMap(plain, coordinates, Scaled(plain, 0.9), OptionsOf(256, false));
  EXPECT_EQ(map.Misses, 0);
  ForCovered(map, coordinates, 256, [&](std::size_t t, const SurfacePlace& place) {
    EXPECT_NEAR(map.Heights[t], -0.1 * PositionOf(plain, place).norm(), 2e-4)
      << "a line off the radius by 0.02 meets facets tilted by 0.05";
  });
  EXPECT_LT(map.LowestHeight, -0.0999);
  EXPECT_LT(map.HighestHeight, -0.098);
}

TEST(DisplacementMap, SineReliefOfAPlaneIsItsFormula)
{
  const TriangleMesh plain = PlanePatch(3, 3);
  TriangleMesh detailed = PlanePatch(240, 240);
  const auto relief = [](double x, double y) { return 0.03 * std::sin(12.0 * x) * std::cos(9.0 * y); };
  for (Eigen::Index p = 0; p < detailed.Points.rows(); ++p)
  {
    detailed.Points(p, 2) = relief(detailed.Points(p, 0), detailed.Points(p, 1));
  }
  const TextureCoordinates coordinates = PlaneCoordinates(plain);
  const DisplacementMap map = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(128));
  EXPECT_EQ(map.CoveredTexels, 128 * 128);
  EXPECT_EQ(map.Misses, 0);
  for (int j = 0; j < 128; ++j)
  {
    for (int i = 0; i < 128; ++i)
    {
      const double expected = relief((i + 0.5) / 128, (j + 0.5) / 128);
      // A chord of length h misses a sine of curvature c by c h^2 / 8.
      EXPECT_NEAR(map.Heights[128 * j + i], expected, 0.03 * 225.0 / (8.0 * 240.0 * 240.0));
      EXPECT_EQ(map.Displacements[3 * (128 * j + i) + 2], map.Heights[128 * j + i]);
      EXPECT_EQ(map.Displacements[3 * (128 * j + i)], 0.0F);
    }
  }
}

TEST(DisplacementMap, MissesAreMeasured)
{
  const TriangleMesh plain = PlanePatch(4, 4);
  const TriangleMesh detailed = Translated(PlanePatch(4, 4, 0.5, 1.0), { 0.0, 0.0, 0.01 });
  const DisplacementMap map = BakeDisplacementMap(plain, PlaneCoordinates(plain), detailed, OptionsOf(64));
  EXPECT_EQ(map.Misses, 64 * 32) << "x from 1/2 to 1";
  EXPECT_NEAR(map.MeanMiss, 0.25, 1e-9);
  EXPECT_NEAR(map.LargestMiss, 0.5 - 0.5 / 64, 1e-9) << "at the centers of the last texels";
  EXPECT_NEAR(map.LowestHeight, 0.01, 1e-8);
  EXPECT_NEAR(map.HighestHeight, 0.01, 1e-8);
}

TEST(DisplacementMap, OnlySurfacesThatFaceTheSameWayCount)
{
  const TriangleMesh plain = PlanePatch(1, 1);
  TriangleMesh below = Translated(PlanePatch(1, 1), { 0.0, 0.0, -0.02 });
  below.Triangles.col(1).swap(below.Triangles.col(2));
  const TriangleMesh plate = Join(below, Translated(PlanePatch(1, 1), { 0.0, 0.0, 0.1 }));
  const DisplacementMap map = BakeDisplacementMap(plain, PlaneCoordinates(plain), plate, OptionsOf(32));
  EXPECT_EQ(map.Misses, 0);
  EXPECT_NEAR(map.LowestHeight, 0.1, 1e-8) << "not the lower side, which is nearer";
}

TEST(DisplacementMap, MaximumDistanceLimitsTheSearch)
{
  const TriangleMesh plain = PlanePatch(1, 1);
  const TriangleMesh detailed = Translated(PlanePatch(1, 1), { 0.0, 0.0, 0.2 });
  DisplacementMapOptions options = OptionsOf(32, false);
  EXPECT_EQ(BakeDisplacementMap(plain, PlaneCoordinates(plain), detailed, options).Misses, 32 * 32)
    << "farther than a tenth of the diagonal";
  options.MaximumDistance = 0.21;
  EXPECT_EQ(BakeDisplacementMap(plain, PlaneCoordinates(plain), detailed, options).Misses, 0);
}

TEST(DisplacementMap, TangentSpaceHasTangentNormalBitangent)
{
  const TriangleMesh plain = PlanePatch(2, 2);
  const TriangleMesh moved = Translated(plain, { 0.1, 0.2, 0.3 });
  DisplacementMapOptions options = OptionsOf(16);
  const auto expect = [&](const TextureCoordinates& coordinates, const Eigen::Vector3d& expected) {
    options.Space = DisplacementSpace::Tangent;
    const DisplacementMap map = BakeDisplacementMap(plain, coordinates, moved, options);
    EXPECT_EQ(map.SubdivisionLevels, 0);
    EXPECT_LT((VectorAt(map, 77) - expected).norm(), 1e-7) << VectorAt(map, 77).transpose();
  };
  expect(PlaneCoordinates(plain), { 0.1, 0.3, 0.2 });
  const auto swapped = [](const Eigen::RowVector3d& x) { return Eigen::RowVector2d(x[1], x[0]); };
  expect(CoordinatesBy(plain, swapped), { 0.2, 0.3, 0.1 }); // mirrored: v still grows along the bitangent
  const auto turned = [](const Eigen::RowVector3d& x) { return Eigen::RowVector2d(1.0 - x[1], x[0]); };
  expect(CoordinatesBy(plain, turned), { -0.2, 0.3, 0.1 });
}

TEST(DisplacementMap, TangentVectorsTurnWithTheSurface)
{
  const TriangleMesh plain = BumpySurface(2);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const TriangleMesh detailed = WithLeaningBumps(Subdivided(plain, 2));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const auto turned = [&](TriangleMesh mesh) {
    mesh.Points = (mesh.Points * turn.transpose()).eval();
    return mesh;
  };
  DisplacementMapOptions options = OptionsOf(256);
  options.Space = DisplacementSpace::Tangent;
  const DisplacementMap a = BakeDisplacementMap(plain, coordinates, detailed, options);
  const DisplacementMap b = BakeDisplacementMap(turned(plain), coordinates, turned(detailed), options);
  double largest = 0.0;
  for (std::size_t k = 0; k < a.Displacements.size(); ++k)
  {
    largest = std::max(largest, static_cast<double>(std::abs(a.Displacements[k] - b.Displacements[k])));
  }
  EXPECT_LT(largest, 1e-6);
}

TEST(DisplacementMap, SeamsDoNotShow)
{
  const TriangleMesh plain = BumpySurface(2);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const TriangleMesh detailed = WithLeaningBumps(Subdivided(plain, 2));
  const DisplacementMap whole = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(256));
  const DisplacementMap apart = BakeDisplacementMap(TakenApart(plain), coordinates, detailed, OptionsOf(256));
  EXPECT_EQ(whole.Heights, apart.Heights) << "normals are smooth over doubled points";
  EXPECT_EQ(whole.Displacements, apart.Displacements);
}

TEST(DisplacementMap, CorrespondencesAgreeWithoutOverhang)
{
  const TriangleMesh plain = Icosphere(3);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  TriangleMesh detailed = Subdivided(plain, 2);
  for (Eigen::Index p = 0; p < detailed.Points.rows(); ++p)
  {
    const Eigen::RowVector3d x = detailed.Points.row(p);
    detailed.Points.row(p) *= 1.05 + 0.05 * std::sin(9.0 * x[0]) * std::sin(9.0 * x[1]) * std::sin(9.0 * x[2]);
  }
  const DisplacementMap byIndex = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(512));
  const DisplacementMap byNormal = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(512, false));
  EXPECT_EQ(byIndex.SubdivisionLevels, 2);
  EXPECT_EQ(byNormal.SubdivisionLevels, -1);
  EXPECT_EQ(byIndex.Heights, byNormal.Heights);
  double sum = 0.0, largest = 0.0;
  ForCovered(byIndex, coordinates, 512, [&](std::size_t t, const SurfacePlace&) {
    const double difference = (VectorAt(byIndex, t) - VectorAt(byNormal, t)).norm();
    sum += difference;
    largest = std::max(largest, difference);
  });
  const double mean = sum / static_cast<double>(byIndex.CoveredTexels);
  std::printf("by index against along normals, relief 0.1: mean %.2e, largest %.2e\n", mean, largest);
  // Points moved radially; interpolated normals differ from radii by up to 0.02, and the relief is up to 0.1 high.
  EXPECT_LT(mean, 5e-4);
  EXPECT_LT(largest, 2e-3);
}

TEST(DisplacementMap, DisplacedSubdivisionIsTheDetailedSurface)
{
  const TriangleMesh plain = Icosphere(2);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const TriangleMesh base = Subdivided(plain, 4);
  const TriangleMesh detailed = WithLeaningBumps(base);
  const DisplacementMap map = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(1024));
  // Vertices of the subdivision as places of the plain surface, by the triangles that they lie in.
  std::vector<SurfacePlace> places(static_cast<std::size_t>(base.NumberOfPoints()));
  for (Eigen::Index corner = base.Triangles.size() - 1; corner >= 0; --corner)
  {
    const Index point = base.Triangles.data()[corner];
    places[static_cast<std::size_t>(point)] = NearestOnTriangle(
      plain, static_cast<Index>(corner / 3) % plain.NumberOfTriangles(), base.Points.row(point).transpose());
  }
  std::vector<float> found(3 * places.size());
  SampleTexture({ map.Displacements.data(), 1024, 1024, 3 }, TextureWrap::Clamp, coordinates, places.data(),
    static_cast<std::int64_t>(places.size()), found.data());
  std::vector<double> all, atSeams;
  for (std::size_t p = 0; p < places.size(); ++p)
  {
    const auto row = static_cast<Eigen::Index>(p);
    const Eigen::RowVector3d displacement(found[3 * p], found[3 * p + 1], found[3 * p + 2]);
    all.push_back((base.Points.row(row) + displacement - detailed.Points.row(row)).norm() / 0.1);
    if (places[p].Weights.minCoeff() < 1e-9)
    {
      atSeams.push_back(all.back());
    }
  }
  for (auto* errors : { &all, &atSeams })
  {
    std::sort(errors->begin(), errors->end());
    double sum = 0.0;
    for (const double error : *errors)
    {
      sum += error;
    }
    const double mean = sum / static_cast<double>(errors->size());
    const double high = (*errors)[errors->size() * 95 / 100];
    std::printf("round trip, %zu points: mean %.4f, 95th percentile %.4f of the relief\n", errors->size(), mean, high);
    EXPECT_LT(mean, errors == &all ? 0.005 : 0.02);
    EXPECT_LT(high, errors == &all ? 0.02 : 0.04);
  }
}

TEST(DisplacementMap, ScalesAndThreadsChangeNoBit)
{
  const TriangleMesh plain = BumpySurface(2);
  const TextureCoordinates coordinates = TriangleGrid(plain.NumberOfTriangles());
  const TriangleMesh detailed = WithLeaningBumps(Subdivided(plain, 1));
  const DisplacementMap expected = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(200));
  for (int threads = 1; threads <= 4; ++threads)
  {
    const ThreadScope scope(threads);
    const DisplacementMap map = BakeDisplacementMap(plain, coordinates, detailed, OptionsOf(200));
    EXPECT_EQ(map.Heights, expected.Heights);
    EXPECT_EQ(map.Displacements, expected.Displacements);
    EXPECT_EQ(map.MeanMiss, expected.MeanMiss);
  }
  for (const double scale : { 0x1p-60, 0x1p60 })
  {
    const DisplacementMap map = BakeDisplacementMap(
      Scaled(plain, scale), coordinates, Scaled(detailed, scale), OptionsOf(200));
    const auto isScaled = [scale](float a, float b) { return static_cast<double>(a) * scale == b; };
    EXPECT_TRUE(std::equal(expected.Heights.begin(), expected.Heights.end(), map.Heights.begin(), isScaled));
    EXPECT_TRUE(
      std::equal(expected.Displacements.begin(), expected.Displacements.end(), map.Displacements.begin(), isScaled));
  }
}
