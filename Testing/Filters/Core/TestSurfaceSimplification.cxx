// SPDX-License-Identifier: BSD-3-Clause
// Simplification with a map, and relaxation along a surface.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/SurfaceDistance.h"
#include "Core/Mesh/SurfaceRelaxation.h"
#include "Core/Mesh/SurfaceSimplification.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <vector>

using namespace surfsynth;

namespace
{
std::vector<SurfacePlace> FindPlaces(const TriangleMesh& mesh, const PointMatrix& points)
{
  return NearestSurface(mesh).NearestPlaces(points);
}

/// Places on an even grid in each triangle, its corners included.
std::vector<SurfacePlace> GridOn(const TriangleMesh& mesh, int steps)
{
  std::vector<SurfacePlace> places;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int i = 0; i <= steps; ++i)
    {
      for (int j = 0; i + j <= steps; ++j)
      {
        places.push_back({ f, Eigen::Vector3d(steps - i - j, i, j) / steps });
      }
    }
  }
  return places;
}

void ExpectSameTopology(const TriangleMesh& mesh, const TriangleMesh& coarse)
{
  const MeshStatistics expected = ComputeMeshStatistics(mesh);
  const MeshStatistics found = ComputeMeshStatistics(coarse);
  EXPECT_EQ(found.EulerCharacteristic(), expected.EulerCharacteristic());
  EXPECT_EQ(found.Components.size(), expected.Components.size());
  EXPECT_EQ(found.BoundaryLoops, expected.BoundaryLoops);
  EXPECT_TRUE(found.Manifold() && found.ConsistentWinding());
}

/// A ball with an arm along z whose radius is a tenth of its own.
TriangleMesh BallWithArm()
{
  TriangleMesh mesh = test::Icosphere(4);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double wide = std::hypot(mesh.Points(v, 0), mesh.Points(v, 1));
    if (mesh.Points(v, 2) > 0.0 && wide < 0.2)
    {
      mesh.Points(v, 2) += 2.0 * (1.0 - wide / 0.2);
    }
  }
  return mesh;
}
} // namespace

TEST(SurfaceSimplification, KeepsTheTopologyOfAnySurface)
{
  for (const TriangleMesh& mesh : { test::Icosphere(3), test::Torus(30, 15), test::PlanePatch(20, 20, 1.0, 1.0) })
  {
    const SurfaceSimplification simplification(mesh, 40);
    ExpectSameTopology(mesh, simplification.Coarse());
    EXPECT_LE(simplification.Coarse().NumberOfTriangles(), 40);
    EXPECT_GE(simplification.Coarse().NumberOfTriangles(), 20);
  }
}

TEST(SurfaceSimplification, StopsBeforeTheTopologyWouldChange)
{
  for (const TriangleMesh& mesh : { test::Icosphere(2), test::Torus(12, 9), test::PlanePatch(6, 6, 1.0, 1.0) })
  {
    ExpectSameTopology(mesh, SurfaceSimplification(mesh, 0).Coarse());
  }
}

TEST(SurfaceSimplification, KeepsAllComponents)
{
  const TriangleMesh ball = test::Icosphere(2);
  const TriangleMesh sheet = test::Translated(test::PlanePatch(6, 6, 0.2, 0.2), { 3.0, 0.0, 0.0 });
  TriangleMesh both = ball;
  both.Points.conservativeResize(ball.NumberOfPoints() + sheet.NumberOfPoints(), 3);
  both.Points.bottomRows(sheet.NumberOfPoints()) = sheet.Points;
  both.Triangles.conservativeResize(ball.NumberOfTriangles() + sheet.NumberOfTriangles(), 3);
  both.Triangles.bottomRows(sheet.NumberOfTriangles()) = sheet.Triangles.array() + ball.NumberOfPoints();
  for (const Index wanted : { 40, 0 })
  {
    ExpectSameTopology(both, SurfaceSimplification(both, wanted).Coarse());
  }
}

TEST(SurfaceSimplification, MapsPointsOntoThemselves)
{
  const TriangleMesh ball = test::Icosphere(3);
  const SurfaceSimplification simplification(ball, 60);
  const TriangleMesh& coarse = simplification.Coarse();
  for (const SurfacePlace& place : GridOn(coarse, 1))
  {
    const SurfacePlace found = simplification.OnInput({ place }).front();
    EXPECT_NEAR((PositionOf(ball, found) - PositionOf(coarse, place)).norm(), 0.0, 1e-12);
  }
  for (Index v = 0; v < coarse.NumberOfPoints(); ++v)
  {
    EXPECT_EQ(coarse.Points.row(v), ball.Points.row(simplification.PointsOnInput()[v]));
  }
}

TEST(SurfaceSimplification, MapIsOneToOne)
{
  // In the plane the images of small triangles are triangles that together cover the patch, and none is turned over.
  const TriangleMesh patch = test::PlanePatch(24, 24, 1.0, 1.0);
  const SurfaceSimplification simplification(patch, 20);
  constexpr int Steps = 64;
  double area = 0.0;
  const TriangleMesh& coarse = simplification.Coarse();
  for (Index f = 0; f < coarse.NumberOfTriangles(); ++f)
  {
    const auto at = [&](int i, int j) {
      const SurfacePlace place{ f, Eigen::Vector3d(Steps - i - j, i, j) / Steps };
      return PositionOf(patch, simplification.OnInput({ place }).front());
    };
    for (int i = 0; i < Steps; i += 8)
    {
      for (int j = 0; i + j < Steps; j += 8)
      {
        const Eigen::Vector3d a = at(i, j);
        const double twice = (at(i + 8, j) - a).cross(at(i, j + 8) - a).z();
        EXPECT_GT(twice, 0.0);
        area += 0.5 * twice;
        if (i + j + 8 < Steps)
        {
          area += 0.5 * (at(i, j + 8) - at(i + 8, j + 8)).cross(at(i + 8, j) - at(i + 8, j + 8)).z();
        }
      }
    }
  }
  EXPECT_NEAR(area, 1.0, 1e-2);
}

TEST(SurfaceSimplification, MapsTheBoundaryOntoTheBoundary)
{
  const TriangleMesh patch = test::PlanePatch(16, 16, 1.0, 1.0);
  const SurfaceSimplification simplification(patch, 20);
  const TriangleMesh& coarse = simplification.Coarse();
  const MeshTopology topology(coarse);
  int ends = 0;
  for (Index f = 0; f < coarse.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const Index a = coarse.Triangles(f, k);
      const Index b = coarse.Triangles(f, (k + 1) % 3);
      for (Index i = topology.NeighborStart[a]; i < topology.NeighborStart[a + 1]; ++i)
      {
        if (topology.Neighbors[i] == b && topology.EdgeTriangles[i] == 1)
        {
          Eigen::Vector3d weights = Eigen::Vector3d::Zero();
          weights[k] = 0.3;
          weights[(k + 1) % 3] = 0.7;
          const Eigen::Vector3d p = PositionOf(patch, simplification.OnInput({ { f, weights } }).front());
          EXPECT_NEAR(std::min({ p.x(), p.y(), 1.0 - p.x(), 1.0 - p.y() }), 0.0, 1e-9);
          ++ends;
        }
      }
    }
  }
  EXPECT_GE(ends, 4);
}

TEST(SurfaceSimplification, KeepsTips)
{
  const TriangleMesh mesh = BallWithArm();
  const TriangleMesh coarse = SurfaceSimplification(mesh, 80).Coarse();
  EXPECT_GT(coarse.Points.col(2).maxCoeff(), 2.9);
}

TEST(SurfaceSimplification, RefusesWhatHasNoTopologyToKeep)
{
  TriangleMesh broken = test::Icosphere(1);
  broken.Triangles.row(0).reverseInPlace();
  EXPECT_THROW(SurfaceSimplification(broken, 10), InvalidInput);
  broken = test::Icosphere(1);
  broken.Points(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SurfaceSimplification(broken, 10), InvalidInput);
  const SurfaceSimplification simplification(test::Icosphere(1), 20);
  EXPECT_THROW(simplification.OnInput({ { 999, { 1.0, 0.0, 0.0 } } }), InvalidInput);
  EXPECT_THROW(SurfaceSimplification(test::Icosphere(5), 20, [](double) { return false; }), Cancelled);
}

TEST(SurfaceRelaxation, EvensTrianglesAndStaysOnTheSurface)
{
  const TriangleMesh ball = test::Icosphere(4);
  TriangleMesh mesh = test::Icosphere(2);
  mesh.Points.col(2) = (mesh.Points.col(2).array() + 0.8).matrix(); // crowded around the north pole
  mesh.Points.rowwise().normalize();
  const double before = ComputeMeshStatistics(mesh).EdgeLength.Maximum;
  const MeshTopology topology(mesh);
  RelaxOnSurface(mesh, topology, NearestSurface(ball), 100);
  EXPECT_LT(ComputeMeshStatistics(mesh).EdgeLength.Maximum, 0.7 * before);
  EXPECT_LT(DistancesTo(ball, mesh.Points, FindPlaces).maxCoeff(), 1e-12);
}

TEST(SurfaceRelaxation, KeepsTheBoundaryOnTheBoundary)
{
  const TriangleMesh patch = test::PlanePatch(9, 9, 1.0, 1.0);
  TriangleMesh mesh = patch;
  const MeshTopology topology(mesh);
  mesh.Points.col(0) = mesh.Points.col(0).array().square().matrix(); // crowded at x = 0
  RelaxOnSurface(mesh, topology, NearestSurface(patch), 20);
  int onBoundary = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (topology.IsOnBoundary(v))
    {
      const Eigen::RowVector3d p = mesh.Points.row(v);
      EXPECT_NEAR(std::min({ p.x(), p.y(), 1.0 - p.x(), 1.0 - p.y() }), 0.0, 1e-12);
      ++onBoundary;
    }
  }
  EXPECT_GT(onBoundary, 20);
}

TEST(SurfaceRelaxation, DoesNotJumpToTheOtherSide)
{
  TriangleMesh plate = test::PlanePatch(3, 3, 1.0, 1.0);
  const NearestSurface surface(plate);
  const Eigen::RowVector3d point(0.4, 0.4, 0.1);
  EXPECT_TRUE(surface.Nearest(point, { 0.0, 0.0, 1.0 }).has_value());
  EXPECT_FALSE(surface.Nearest(point, { 0.0, 0.0, -1.0 }).has_value());
}

TEST(SurfaceRelaxation, SmoothsFoldsAndNothingElse)
{
  const TriangleMesh plane = test::PlanePatch(12, 12, 1.0, 1.0);
  TriangleMesh mesh = plane;
  const MeshTopology topology(mesh);
  EXPECT_EQ(SmoothFolds(mesh, topology, 100), 0);
  EXPECT_EQ(mesh.Points, plane.Points);
  Index inner = 0;
  while ((mesh.Points.row(inner) - Eigen::RowVector3d(0.5, 0.5, 0.0)).norm() > 0.1)
  {
    ++inner;
  }
  mesh.Points(inner, 0) += 0.2; // beyond its neighbor
  EXPECT_EQ(SmoothFolds(mesh, topology, 100), 0);
  EXPECT_LT((mesh.Points.col(2)).cwiseAbs().maxCoeff(), 1e-15);
  const double far = (mesh.Points.row(0) - plane.Points.row(0)).norm();
  EXPECT_EQ(far, 0.0);
}

TEST(MeanNormalAngle, IsTheAngleBetweenPlanes)
{
  const TriangleMesh flat = test::PlanePatch(3, 3, 1.0, 1.0);
  EXPECT_NEAR(MeanNormalAngle(flat, flat, FindPlaces, 1000), 0.0, 1e-6);
  TriangleMesh turned = flat;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
  turned.Points = flat.Points * turn.transpose();
  EXPECT_NEAR(MeanNormalAngle(flat, turned, FindPlaces, 1000), 0.5 * 180.0 / std::acos(-1.0), 1e-9);
}
