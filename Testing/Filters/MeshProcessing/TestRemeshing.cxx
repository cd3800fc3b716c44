// SPDX-License-Identifier: BSD-3-Clause
//
// RemeshIsotropically(): edge lengths, what is kept, places on the input, errors.
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshStatistics.h"
#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>
#include <tuple>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

namespace
{
RemeshingOptions WithEdges(double length)
{
  RemeshingOptions options;
  options.EdgeLength = length;
  options.Finder = NearestPlaces;
  return options;
}

/// [0, 1]^3 with 48 triangles.
TriangleMesh SplitCube()
{
  return Scaled(SurfaceOfCubes({ { 0, 0, 0 }, { 0, 0, 1 }, { 0, 1, 0 }, { 0, 1, 1 }, { 1, 0, 0 }, { 1, 0, 1 },
                  { 1, 1, 0 }, { 1, 1, 1 } }),
    0.5);
}

/// Mean length of the edges of triangles whose centroid lies between two heights.
double MeanEdgeBetween(const TriangleMesh& mesh, double lower, double upper)
{
  TriangleMesh part{ mesh.Points, mesh.Triangles };
  Index kept = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const double height = (mesh.Points(t(0), 2) + mesh.Points(t(1), 2) + mesh.Points(t(2), 2)) / 3.0;
    if (height >= lower && height <= upper)
    {
      part.Triangles.row(kept++) = t;
    }
  }
  part.Triangles.conservativeResize(kept, 3);
  return MeanSideLength(part);
}
} // namespace

TEST(RemeshIsotropically, EdgesAreEvenAndPointsStayOnTheSurface)
{
  const TriangleMesh sphere = Icosphere(4); // with edges of a third of the length
  const double length = 0.2;
  const RemeshedSurface made = RemeshIsotropically(sphere, WithEdges(length));
  EXPECT_EQ(DefectsOf(made.Mesh), "");
  const MeshStatistics statistics = ComputeMeshStatistics(made.Mesh);
  EXPECT_EQ(statistics.EulerCharacteristic(), 2);
  EXPECT_GT(statistics.EdgeLength.Mean, 0.85 * length); // about 8 per cent below the target
  EXPECT_LT(statistics.EdgeLength.Mean, length);
  EXPECT_GT(statistics.EdgeLength.Minimum, 0.5 * length);
  EXPECT_LT(statistics.EdgeLength.Maximum, 1.5 * length);
  EXPECT_GT(statistics.SmallestAngle.Minimum, 30.0);
  EXPECT_LT(LargestDistance(made.Mesh.Points, sphere), 1e-9);
  EXPECT_NEAR(statistics.Area, AreaOf(sphere), 0.02 * AreaOf(sphere));
}

TEST(RemeshIsotropically, MeanEdgeLengthIsMetWhenAsked)
{
  RemeshingOptions options = WithEdges(0.25);
  options.MatchMeanEdgeLength = true;
  EXPECT_NEAR(MeanSideLength(RemeshIsotropically(Icosphere(3), options).Mesh), 0.25, 0.02 * 0.25);
}

TEST(RemeshIsotropically, NumberOfPointsIsMetWithinTwoPerCent)
{
  for (const std::int64_t points : { 400, 1500 })
  {
    RemeshingOptions options = WithEdges(1.0);
    options.NumberOfPoints = points;
    const RemeshedSurface made = RemeshIsotropically(Icosphere(3), options);
    EXPECT_NEAR(made.Mesh.NumberOfPoints(), points, 0.02 * points);
    EXPECT_EQ(DefectsOf(made.Mesh), "");
  }
}

TEST(RemeshIsotropically, EdgeLengthsVaryAsAskedFor)
{
  const TriangleMesh sphere = Icosphere(4);
  RemeshingOptions options = WithEdges(1.0);
  for (Index v = 0; v < sphere.NumberOfPoints(); ++v)
  {
    options.PointEdgeLengths.push_back(0.15 + 0.075 * sphere.Points(v, 2)); // 0.075 to 0.225
  }
  const RemeshedSurface made = RemeshIsotropically(sphere, options);
  EXPECT_EQ(DefectsOf(made.Mesh), "");
  // Lengths at the middle heights of the caps, within 15 per cent.
  EXPECT_NEAR(MeanEdgeBetween(made.Mesh, 0.6, 1.0), 0.15 + 0.075 * 0.8, 0.15 * 0.21);
  EXPECT_NEAR(MeanEdgeBetween(made.Mesh, -1.0, -0.6), 0.15 - 0.075 * 0.8, 0.15 * 0.09);
}

TEST(RemeshIsotropically, BoundaryStaysOnItsCurve)
{
  const TriangleMesh patch = PlanePatch(6, 6, 1.0, 1.0, 0.2);
  const RemeshedSurface made = RemeshIsotropically(patch, WithEdges(0.08));
  EXPECT_EQ(DefectsOf(made.Mesh, false), "");
  EXPECT_GT(made.Mesh.NumberOfPoints(), 2 * patch.NumberOfPoints());
  EXPECT_NEAR(AreaOf(made.Mesh), 1.0, 1e-9); // with its corners
  EXPECT_EQ(ComputeMeshStatistics(made.Mesh).BoundaryLoops, 1);
  EXPECT_LT(made.Mesh.Points.col(2).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(RemeshIsotropically, ATriangleByItselfKeepsItsCorners)
{
  // Obtuse and smaller than the edges that are asked for, as scans leave beside a piece that is cut out of them.
  TriangleMesh mesh = PlanePatch(6, 6, 8.0, 8.0, 0.2);
  const Index first = mesh.NumberOfPoints();
  mesh.Points.conservativeResize(first + 3, 3);
  mesh.Points.bottomRows(3) << 31.42, 25.41, 49.16, 30.95, 25.67, 48.99, 31.05, 25.67, 48.99;
  mesh.Triangles.conservativeResize(mesh.NumberOfTriangles() + 1, 3);
  mesh.Triangles.bottomRows(1) << first, first + 2, first + 1;
  for (const double length : { 0.3, 0.5, 1.0, 3.0 })
  {
    RemeshingOptions options = WithEdges(length);
    for (const bool varies : { false, true })
    {
      options.PointEdgeLengths.assign(varies ? static_cast<std::size_t>(mesh.NumberOfPoints()) : 0, length);
      const RemeshedSurface made = RemeshIsotropically(mesh, options);
      EXPECT_EQ(DefectsOf(made.Mesh, false), "") << length;
      EXPECT_NEAR(AreaOf(made.Mesh), AreaOf(mesh), 1e-9) << length;
    }
  }
}

TEST(RemeshIsotropically, BoundaryPointsStayWhenAsked)
{
  const TriangleMesh patch = PlanePatch(8, 8);
  RemeshingOptions options = WithEdges(0.3);
  options.KeepBoundaryPoints = true;
  const RemeshedSurface made = RemeshIsotropically(patch, options);
  std::set<std::tuple<double, double, double>> points;
  for (const auto& point : made.Mesh.Points.rowwise())
  {
    points.insert({ point(0), point(1), point(2) });
  }
  int kept = 0;
  for (const auto& point : patch.Points.rowwise())
  {
    const bool onBoundary = point(0) == 0.0 || point(0) == 1.0 || point(1) == 0.0 || point(1) == 1.0;
    kept += onBoundary && points.count({ point(0), point(1), point(2) }) > 0 ? 1 : 0;
  }
  EXPECT_EQ(kept, 32);
  EXPECT_LT(made.Mesh.NumberOfPoints(), patch.NumberOfPoints()); // the inside has become coarser
}

TEST(RemeshIsotropically, CreasesAndCornersAreKept)
{
  RemeshingOptions options = WithEdges(0.15);
  options.FeatureAngle = 45.0;
  const RemeshedSurface sharp = RemeshIsotropically(SplitCube(), options);
  EXPECT_EQ(DefectsOf(sharp.Mesh), "");
  EXPECT_NEAR(AreaOf(sharp.Mesh), 6.0, 1e-9);
  EXPECT_NEAR(VolumeOf(sharp.Mesh), 1.0, 1e-9);
  // Without creases the edges of the cube are cut off.
  options.FeatureAngle = 180.0;
  EXPECT_LT(VolumeOf(RemeshIsotropically(SplitCube(), options).Mesh), 0.999);
}

TEST(RemeshIsotropically, CreasesStayWhenLengthsAtPointsMakeThemCoarser)
{
  RemeshingOptions options = WithEdges(0.06);
  options.FeatureAngle = 45.0;
  const TriangleMesh fine = RemeshIsotropically(SplitCube(), options).Mesh;
  options.PointEdgeLengths.assign(static_cast<std::size_t>(fine.NumberOfPoints()), 0.2);
  const RemeshedSurface coarse = RemeshIsotropically(fine, options);
  EXPECT_EQ(DefectsOf(coarse.Mesh), "");
  EXPECT_LT(4 * coarse.Mesh.NumberOfPoints(), fine.NumberOfPoints());
  EXPECT_NEAR(AreaOf(coarse.Mesh), 6.0, 1e-9);
  EXPECT_NEAR(VolumeOf(coarse.Mesh), 1.0, 1e-9);
}

TEST(RemeshIsotropically, PlacesAndOriginsAreOnTheInput)
{
  const TriangleMesh torus = Torus(24, 12);
  const RemeshedSurface made = RemeshIsotropically(torus, WithEdges(0.25));
  ASSERT_EQ(made.PlaceOfPoint.size(), static_cast<std::size_t>(made.Mesh.NumberOfPoints()));
  for (Index v = 0; v < made.Mesh.NumberOfPoints(); ++v)
  {
    EXPECT_LT((PositionOf(torus, made.PlaceOfPoint[v]) - made.Mesh.Points.row(v).transpose()).norm(), 1e-9) << v;
  }
  ASSERT_EQ(made.OriginOfTriangle.size(), static_cast<std::size_t>(made.Mesh.NumberOfTriangles()));
  for (Index f = 0; f < made.Mesh.NumberOfTriangles(); ++f)
  {
    const auto t = made.Mesh.Triangles.row(f);
    const PointMatrix center = (made.Mesh.Points.row(t(0)) + made.Mesh.Points.row(t(1)) + made.Mesh.Points.row(t(2))) /
      3.0;
    const SurfacePlace nearest = NearestPlaces(torus, center)[0];
    const SurfacePlace origin = NearestOnTriangle(torus, made.OriginOfTriangle[f], center.row(0).transpose());
    EXPECT_EQ(PositionOf(torus, origin), PositionOf(torus, nearest)) << f;
  }
}

TEST(RemeshIsotropically, WithoutPlacesNoFinderIsNeeded)
{
  RemeshingOptions options = WithEdges(0.3);
  const RemeshedSurface with = RemeshIsotropically(Icosphere(2), options);
  options.Finder = {};
  options.FindPlaces = options.FindOrigins = false;
  const RemeshedSurface without = RemeshIsotropically(Icosphere(2), options);
  EXPECT_EQ(without.Mesh.Points, with.Mesh.Points);
  EXPECT_EQ(without.Mesh.Triangles, with.Mesh.Triangles);
  EXPECT_TRUE(without.OriginOfTriangle.empty());
}

TEST(RemeshIsotropically, NonManifoldMeshesAreInvalid)
{
  TriangleMesh fins = Tetrahedron();
  fins.Points.conservativeResize(5, 3);
  fins.Points.row(4) << 3.0, 3.0, 3.0;
  fins.Triangles.conservativeResize(5, 3);
  fins.Triangles.row(4) << fins.Triangles(0, 0), fins.Triangles(0, 1), 4;
  EXPECT_THAT([&] { RemeshIsotropically(fins, WithEdges(0.3)); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("not manifold"), HasSubstr("triangle 4; vtkSurfaceRepairFilter"))));

  TriangleMesh twice = SingleTriangle();
  twice.Triangles.conservativeResize(2, 3);
  twice.Triangles.row(1) << 0, 2, 1;
  EXPECT_THAT([&] { RemeshIsotropically(twice, WithEdges(0.3)); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("have the same three points"), HasSubstr("vtkSurfaceRepairFilter"))));
}

TEST(RemeshIsotropically, StopIsCancelled)
{
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(RemeshIsotropically(Icosphere(2), WithEdges(0.3), &stop), Cancelled);
}
