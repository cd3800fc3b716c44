// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/TriangleAdjacency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

using namespace surfsynth;

namespace
{
const double Pi = std::acos(-1.0);
const double NaN = std::numeric_limits<double>::quiet_NaN();

TriangleMesh Make(const std::vector<double>& points, const std::vector<Index>& corners)
{
  TriangleMesh mesh;
  mesh.Points = Eigen::Map<const PointMatrix>(points.data(), static_cast<Eigen::Index>(points.size() / 3), 3);
  mesh.Triangles = Eigen::Map<const TriangleMatrix>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return mesh;
}

/// The unit cube, wound outwards.
TriangleMesh Cube()
{
  return Make({ 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1 },
    { 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7 });
}

TriangleMesh WithTriangle(TriangleMesh mesh, Index a, Index b, Index c)
{
  mesh.Triangles.conservativeResize(mesh.Triangles.rows() + 1, 3);
  mesh.Triangles.bottomRows(1) << a, b, c;
  return mesh;
}

/// The finding of a kind; its count is 0 when there is none.
MeshFinding FindingOf(const MeshStatistics& statistics, MeshDefect defect)
{
  for (const MeshFinding& finding : statistics.Findings)
  {
    if (finding.Defect == defect)
    {
      return finding;
    }
  }
  return { defect };
}

class StatisticsOfSuite : public testing::TestWithParam<std::string>
{};

INSTANTIATE_TEST_SUITE_P(
  Suite, StatisticsOfSuite, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });
} // namespace

TEST_P(StatisticsOfSuite, AgreeWithWhatIsKnownOfTheMesh)
{
  const test::SuiteMesh& suite = test::FromSuite(GetParam());
  const MeshStatistics statistics = ComputeMeshStatistics(suite.Mesh);
  EXPECT_EQ(static_cast<int>(statistics.Components.size()), suite.Components);
  EXPECT_EQ(statistics.EulerCharacteristic(), suite.EulerCharacteristic);
  EXPECT_EQ(statistics.Closed(), suite.Closed);
  EXPECT_EQ(statistics.BoundaryLoops == 0, suite.Closed);
  EXPECT_EQ(statistics.ConsistentWinding(), suite.ConsistentWinding);
  EXPECT_EQ(statistics.UnreferencedPoints.Count, suite.UnusedPoints);
  EXPECT_EQ(statistics.UsedPoints - statistics.Edges + statistics.ProperTriangles, suite.EulerCharacteristic);
  EXPECT_EQ(statistics.CoincidentPoints.Count, 0);
  EXPECT_EQ(statistics.DuplicateTriangles.Count, 0);
  EXPECT_TRUE(statistics.Manifold());
  EXPECT_EQ(FindingOf(statistics, MeshDefect::DegenerateTriangle).Count, 0);
  EXPECT_EQ(statistics.SmallestAngle.Count, statistics.Triangles);
  EXPECT_GT(statistics.SmallestAngle.Minimum, 0.0);
  EXPECT_LT(statistics.LargestAngle.Maximum, 180.0);
  EXPECT_GE(statistics.AspectRatio.Minimum, 1.0 - 1e-12);
}

TEST(MeshStatistics, CubeHasItsVolumeAreaAndAngles)
{
  const MeshStatistics cube = ComputeMeshStatistics(Cube());
  EXPECT_NEAR(cube.Volume().value(), 1.0, 1e-14);
  EXPECT_NEAR(cube.Area, 6.0, 1e-14);
  EXPECT_EQ(cube.Genus(), 0);
  EXPECT_EQ(cube.Edges, 18);
  EXPECT_EQ(cube.EdgeLength.Count, 18);
  EXPECT_DOUBLE_EQ(cube.EdgeLength.Minimum, 1.0);
  EXPECT_DOUBLE_EQ(cube.EdgeLength.Median, 1.0);
  EXPECT_DOUBLE_EQ(cube.EdgeLength.Maximum, std::sqrt(2.0));
  EXPECT_NEAR(cube.EdgeLength.Mean, (12.0 + 6.0 * std::sqrt(2.0)) / 18.0, 1e-14);
  EXPECT_NEAR(cube.SmallestAngle.Minimum, 45.0, 1e-12);
  EXPECT_NEAR(cube.SmallestAngle.Mean, 45.0, 1e-12);
  EXPECT_NEAR(cube.LargestAngle.Maximum, 90.0, 1e-12);
  // longest edge sqrt(2), perimeter 2 + sqrt(2), area 1/2
  EXPECT_NEAR(cube.AspectRatio.Maximum, std::sqrt(2.0) * (2.0 + std::sqrt(2.0)) / (2.0 * std::sqrt(3.0)), 1e-12);
  EXPECT_EQ(cube.Box.Upper, Eigen::Vector3d::Ones());
  EXPECT_TRUE(cube.Findings.empty());
}

TEST(MeshStatistics, EquilateralTriangleHasAspectRatioOne)
{
  const MeshStatistics one = ComputeMeshStatistics(Make({ 0, 0, 0, 2, 0, 0, 1, std::sqrt(3.0), 0 }, { 0, 1, 2 }));
  EXPECT_NEAR(one.AspectRatio.Maximum, 1.0, 1e-14);
  EXPECT_NEAR(one.SmallestAngle.Minimum, 60.0, 1e-12);
  EXPECT_NEAR(one.LargestAngle.Maximum, 60.0, 1e-12);
  EXPECT_EQ(one.BoundaryLoops, 1);
  EXPECT_NEAR(one.LongestBoundaryLoop, 6.0, 1e-14);
  EXPECT_EQ(one.Genus(), 0) << "a disk";
  EXPECT_FALSE(one.Volume().has_value());
}

TEST(MeshStatistics, VolumeOfTheSphereConvergesAndTellsTheWinding)
{
  TriangleMesh sphere = test::Icosphere(4, 2.0);
  const double exact = 4.0 / 3.0 * Pi * 8.0;
  EXPECT_NEAR(ComputeMeshStatistics(sphere).Volume().value(), exact, 0.005 * exact);
  const auto moved = ComputeMeshStatistics(test::Translated(sphere, { 1e6, -1e6, 1e6 }));
  EXPECT_NEAR(moved.Volume().value(), exact, 0.005 * exact) << "measured from the middle of the box";
  sphere.Triangles.col(0).swap(sphere.Triangles.col(1));
  EXPECT_NEAR(ComputeMeshStatistics(sphere).Volume().value(), -exact, 0.005 * exact) << "wound inwards";
}

TEST(MeshStatistics, VolumeOfAnInconsistentlyWoundSphereIsThatOfTheSphere)
{
  TriangleMesh sphere = test::Icosphere(2);
  const double volume = ComputeMeshStatistics(sphere).Volume().value();
  for (Index f = 0; f < sphere.NumberOfTriangles(); f += 3)
  {
    std::swap(sphere.Triangles(f, 0), sphere.Triangles(f, 1));
  }
  const MeshStatistics statistics = ComputeMeshStatistics(sphere);
  EXPECT_FALSE(statistics.ConsistentWinding());
  EXPECT_TRUE(statistics.Orientable());
  EXPECT_NEAR(statistics.Volume().value(), volume, 1e-12);
  EXPECT_GT(FindingOf(statistics, MeshDefect::InconsistentWinding).Count, 0);
}

TEST(MeshStatistics, TorusHasGenusOneAndItsVolume)
{
  const MeshStatistics torus = ComputeMeshStatistics(test::Torus(200, 100, 1.0, 0.4));
  EXPECT_EQ(torus.Genus(), 1);
  EXPECT_EQ(torus.EulerCharacteristic(), 0);
  EXPECT_NEAR(std::abs(torus.Volume().value()), 2.0 * Pi * Pi * 0.16, 0.01);
}

TEST(MeshStatistics, TwoToriHaveGenusTwoInAll)
{
  const TriangleMesh torus = test::Torus(20, 10);
  const auto two = ComputeMeshStatistics(test::Join(torus, test::Translated(torus, { 5, 0, 0 })));
  ASSERT_EQ(two.Components.size(), 2u);
  EXPECT_EQ(two.Genus(), 2);
  EXPECT_EQ(two.Components[1].Genus, 1);
  EXPECT_EQ(two.Components[1].FirstPoint, torus.NumberOfPoints());
  EXPECT_EQ(two.Components[1].Triangles, torus.NumberOfTriangles());
}

TEST(MeshStatistics, MoebiusStripIsNotOrientableAndHasNoGenus)
{
  const MeshStatistics strip = ComputeMeshStatistics(test::MoebiusStrip(24, 3));
  EXPECT_FALSE(strip.Orientable());
  EXPECT_FALSE(strip.ConsistentWinding());
  EXPECT_TRUE(strip.Manifold());
  EXPECT_EQ(strip.BoundaryLoops, 1);
  EXPECT_EQ(strip.EulerCharacteristic(), 0);
  EXPECT_FALSE(strip.Genus().has_value());
}

TEST(MeshStatistics, CylinderHasTwoLoopsOfItsCircumference)
{
  const MeshStatistics cylinder = ComputeMeshStatistics(test::OpenCylinder(200, 5, 1.5));
  EXPECT_EQ(cylinder.BoundaryLoops, 2);
  EXPECT_EQ(cylinder.Genus(), 0);
  EXPECT_NEAR(cylinder.LongestBoundaryLoop, 2.0 * Pi * 1.5, 0.01);
}

TEST(MeshStatistics, TwoTrianglesThatTouchInAPointHaveTwoLoops)
{
  const auto bow = ComputeMeshStatistics(Make({ 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0 }, { 0, 1, 2, 0, 3, 4 }));
  EXPECT_EQ(bow.BoundaryLoops, 2);
  EXPECT_EQ(bow.Components.size(), 1u);
  EXPECT_FALSE(bow.Manifold());
  EXPECT_FALSE(bow.Genus().has_value());
  EXPECT_EQ(FindingOf(bow, MeshDefect::NonManifoldVertex).Count, 1);
}

TEST(MeshStatistics, LoopsDoNotDependOnTheWinding)
{
  TriangleMesh patch = test::PlanePatch(6, 4, 3.0, 2.0);
  for (Index f = 0; f < patch.NumberOfTriangles(); f += 2)
  {
    std::swap(patch.Triangles(f, 0), patch.Triangles(f, 1));
  }
  const MeshStatistics statistics = ComputeMeshStatistics(patch);
  EXPECT_EQ(statistics.BoundaryLoops, 1);
  EXPECT_NEAR(statistics.LongestBoundaryLoop, 10.0, 1e-12);
}

TEST(MeshStatistics, EveryDefectIsFoundAtOnce)
{
  TriangleMesh mesh = test::Join(Cube(), test::PlanePatch(2, 2)); // points 0..7 and 8..16, triangles 0..11 and 12..19
  mesh.Points.row(16)(0) = NaN;
  mesh = WithTriangle(mesh, 0, 1, 99); // 20
  mesh = WithTriangle(mesh, -1, 1, 2); // 21
  mesh = WithTriangle(mesh, 0, 0, 1);  // 22
  mesh = WithTriangle(mesh, 8, 9, 10); // 23, on one line
  mesh = WithTriangle(mesh, 0, 1, 2);  // 24, 2 triangles have these corners
  const MeshStatistics statistics = ComputeMeshStatistics(mesh);
  const auto expect = [&](MeshDefect defect, std::int64_t count, std::int64_t first) {
    const MeshFinding finding = FindingOf(statistics, defect);
    EXPECT_EQ(finding.Count, count) << RepairOf(defect);
    EXPECT_EQ(finding.First, first) << RepairOf(defect);
  };
  expect(MeshDefect::IndexOutOfRange, 2, 20);
  expect(MeshDefect::NonFinitePoint, 1, 16);
  expect(MeshDefect::RepeatedVertex, 1, 22);
  expect(MeshDefect::DegenerateTriangle, 1, 23);
  expect(MeshDefect::NonManifoldEdge, 3, 0);
  expect(MeshDefect::SeveralComponents, 2, 8);
  EXPECT_GT(FindingOf(statistics, MeshDefect::BoundaryEdge).Count, 0);
  EXPECT_EQ(statistics.ProperTriangles, 22);
  EXPECT_EQ(statistics.DuplicateTriangles.Count, 1);
  EXPECT_EQ(statistics.DuplicateTriangles.First, 24);
  EXPECT_TRUE(std::isfinite(statistics.Area));
  EXPECT_TRUE(std::isfinite(statistics.EdgeLength.Maximum));
  EXPECT_TRUE(statistics.Box.Upper.allFinite());
}

TEST(MeshStatistics, AnEmptyMeshHasNoNumbers)
{
  for (const bool withPoints : { false, true })
  {
    TriangleMesh mesh;
    mesh.Points = withPoints ? PointMatrix(PointMatrix::Ones(3, 3)) : PointMatrix(0, 3);
    mesh.Triangles.resize(0, 3);
    const MeshStatistics statistics = ComputeMeshStatistics(mesh);
    EXPECT_EQ(statistics.UnreferencedPoints.Count, withPoints ? 3 : 0);
    EXPECT_FALSE(statistics.Closed());
    EXPECT_FALSE(statistics.Genus().has_value());
    EXPECT_FALSE(statistics.Volume().has_value());
    EXPECT_EQ(statistics.EdgeLength.Count, 0);
    EXPECT_TRUE(statistics.Findings.empty());
  }
}

TEST(MeshStatistics, CoincidentPointsAndSmallComponentsAreCounted)
{
  const TriangleMesh sphere = test::Icosphere(2);
  const auto twice = ComputeMeshStatistics(test::Join(sphere, sphere));
  EXPECT_EQ(twice.CoincidentPoints.Count, sphere.NumberOfPoints());
  EXPECT_EQ(twice.CoincidentPoints.First, sphere.NumberOfPoints());
  EXPECT_EQ(twice.SmallComponents.Count, 0);
  const auto speck = ComputeMeshStatistics(test::Join(test::Tetrahedron(), test::Icosphere(3)));
  EXPECT_EQ(speck.SmallComponents.Count, 1);
  EXPECT_EQ(speck.SmallComponents.First, 0);
}

TEST(MeshStatistics, NumbersScaleWithTheMesh)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const MeshStatistics one = ComputeMeshStatistics(mesh);
  const MeshStatistics large = ComputeMeshStatistics(test::Scaled(mesh, 8.0));
  EXPECT_NEAR(large.Area, 64.0 * one.Area, 1e-9 * large.Area);
  EXPECT_NEAR(large.Volume().value(), 512.0 * one.Volume().value(), 1e-9 * large.Volume().value());
  EXPECT_NEAR(large.EdgeLength.Median, 8.0 * one.EdgeLength.Median, 1e-12 * large.EdgeLength.Median);
  EXPECT_NEAR(large.SmallestAngle.Minimum, one.SmallestAngle.Minimum, 1e-9);
}

TEST(MeshStatistics, ExtremeCoordinatesGiveFiniteNumbers)
{
  for (const double scale : { 1e-310, 1e-160, 1e-100, 1e100, 1e160, 1e300 })
  {
    const MeshStatistics statistics = ComputeMeshStatistics(test::Scaled(test::Icosphere(2), scale));
    EXPECT_TRUE(std::isfinite(statistics.Area)) << scale;
    EXPECT_TRUE(std::isfinite(statistics.EdgeLength.Maximum)) << scale;
    EXPECT_TRUE(std::isfinite(statistics.AspectRatio.Maximum)) << scale;
    EXPECT_TRUE(std::isfinite(statistics.Volume().value_or(0.0))) << scale;
    EXPECT_EQ(statistics.Genus(), 0) << "topology needs no coordinates";
  }
}

TEST(MeshStatistics, AreTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(5);
  const MeshStatistics reference = [&] {
    const ThreadScope one(1);
    return ComputeMeshStatistics(mesh);
  }();
  const ThreadScope four(4);
  const MeshStatistics other = ComputeMeshStatistics(mesh);
  EXPECT_EQ(reference.Area, other.Area);
  EXPECT_EQ(reference.Volume(), other.Volume());
  EXPECT_EQ(reference.AspectRatio.Mean, other.AspectRatio.Mean);
  EXPECT_EQ(reference.EdgeLength.Mean, other.EdgeLength.Mean);
}

TEST(MeshStatistics, PolesWithManyTrianglesCostNoMoreThanOthers)
{
  const MeshStatistics globe = ComputeMeshStatistics(test::UvSphere(3, 100000)); // quadratic work would take minutes
  EXPECT_TRUE(globe.Manifold());
  EXPECT_EQ(globe.Genus(), 0);
  EXPECT_EQ(globe.DuplicateTriangles.Count, 0);
}

TEST(MeshStatistics, StopOnRequest)
{
  EXPECT_THROW(ComputeMeshStatistics(test::Icosphere(2), [](double fraction) { return fraction < 0.5; }), Cancelled);
}

TEST(MeanSideLength, CountsInnerEdgesTwice)
{
  EXPECT_NEAR(MeanSideLength(test::SingleTriangle()), (2.0 + 1.0 + std::sqrt(5.0)) / 3.0, 1e-15);
  const TriangleMesh square = Make({ 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 }, { 0, 1, 2, 0, 2, 3 });
  EXPECT_NEAR(MeanSideLength(square), (4.0 + 2.0 * std::sqrt(2.0)) / 6.0, 1e-15);
  EXPECT_EQ(MeanSideLength(TriangleMesh()), 0.0);
}

TEST(TriangleAdjacency, NamesTheTriangleBeyondEachSide)
{
  const TriangleMesh fan = Make(
    { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1 }, { 0, 1, 2, 1, 0, 3, 0, 1, 4, 2, 1, 4 });
  const TriangleAdjacency adjacency(fan, MeshTopology(fan));
  EXPECT_EQ(adjacency.Across(0, 0), TriangleAdjacency::Several);
  EXPECT_EQ(adjacency.Across(0, 1), 3);
  EXPECT_EQ(adjacency.Across(3, 0), 0);
  EXPECT_EQ(adjacency.Across(0, 2), TriangleAdjacency::Boundary);
}
