// SPDX-License-Identifier: BSD-3-Clause
// Straight geodesics against closed forms.
#include "ExampleMeshes.h"

#include "Core/Mesh/GeodesicTracing.h"
#include "Core/Mesh/MeshTopology.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

using namespace surfsynth;

namespace
{
/// A mesh and what geodesics on it need.
struct Traced
{
  explicit Traced(TriangleMesh mesh)
    : Mesh(std::move(mesh))
    , Topology(this->Mesh)
    , Adjacency(this->Mesh, this->Topology)
    , Tracer(this->Mesh, this->Adjacency)
  {}

  /// A direction in the plane of triangle @p f, at an angle from its first edge.
  Eigen::Vector3d Direction(Index f, double angle) const
  {
    const auto corners = this->Mesh.Triangles.row(f);
    const Eigen::Vector3d x = (this->Mesh.Points.row(corners(1)) - this->Mesh.Points.row(corners(0))).normalized();
    return std::cos(angle) * x + std::sin(angle) * this->Tracer.Normal(f).cross(x);
  }

  TriangleMesh Mesh;
  MeshTopology Topology;
  TriangleAdjacency Adjacency;
  GeodesicTracer Tracer;
};

const Eigen::Vector3d Middle = Eigen::Vector3d::Constant(1.0 / 3.0);
} // namespace

TEST(GeodesicTracing, LinesInAPlaneAreStraight)
{
  const Traced plane(test::PlanePatch(20, 20, 1.0, 1.0, 0.3));
  const Index f = 420; // near the middle
  const Eigen::Vector3d start = PositionOf(plane.Mesh, { f, Middle });
  for (int k = 0; k < 12; ++k)
  {
    const Eigen::Vector3d direction = plane.Direction(f, 0.5 * k);
    const GeodesicEnd end = plane.Tracer.Trace({ f, Middle }, direction, 0.4);
    ASSERT_TRUE(end.IsComplete) << k;
    EXPECT_LT((PositionOf(plane.Mesh, end.Place) - start - 0.4 * direction).norm(), 1e-12) << k;
    EXPECT_LT((end.Direction - direction).norm(), 1e-12) << k;
  }
}

TEST(GeodesicTracing, ABoundaryEndsThem)
{
  const Traced plane(test::PlanePatch(8, 8));
  const Index f = 60;
  const Eigen::Vector3d start = PositionOf(plane.Mesh, { f, Middle });
  const BoundingBox box = ComputeBoundingBox(plane.Mesh);
  const Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  const GeodesicEnd end = plane.Tracer.Trace({ f, Middle }, direction, 10.0);
  EXPECT_FALSE(end.IsComplete);
  const Eigen::Vector3d reached = PositionOf(plane.Mesh, end.Place);
  EXPECT_NEAR(reached.x(), box.Upper.x(), 1e-12);
  EXPECT_NEAR(reached.y(), start.y(), 1e-12);
}

TEST(GeodesicTracing, OnASphereTheyAreGreatCircles)
{
  const Traced sphere(test::Icosphere(6));
  const Index f = 1234;
  const Eigen::Vector3d start = PositionOf(sphere.Mesh, { f, Middle }).normalized();
  for (int k = 0; k < 6; ++k)
  {
    const Eigen::Vector3d direction = sphere.Direction(f, k);
    const Eigen::Vector3d tangent = (direction - direction.dot(start) * start).normalized();
    const GeodesicEnd end = sphere.Tracer.Trace({ f, Middle }, direction, 1.5);
    ASSERT_TRUE(end.IsComplete) << k;
    const Eigen::Vector3d expected = std::cos(1.5) * start + std::sin(1.5) * tangent;
    EXPECT_LT((PositionOf(sphere.Mesh, end.Place) - expected).norm(), 0.01) << k;
  }
}

TEST(GeodesicTracing, TheyLeadBack)
{
  const Traced surface(test::BumpySurface(4));
  for (Index f = 0; f < surface.Mesh.NumberOfTriangles(); f += 97)
  {
    const GeodesicEnd there = surface.Tracer.Trace({ f, Middle }, surface.Direction(f, f), 0.7);
    ASSERT_TRUE(there.IsComplete);
    EXPECT_NEAR(there.Direction.norm(), 1.0, 1e-12);
    EXPECT_NEAR(there.Direction.dot(surface.Tracer.Normal(there.Place.Triangle)), 0.0, 1e-12);
    const GeodesicEnd back = surface.Tracer.Trace(there.Place, -there.Direction, 0.7);
    EXPECT_LT((PositionOf(surface.Mesh, back.Place) - PositionOf(surface.Mesh, { f, Middle })).norm(), 1e-6) << f;
  }
}

TEST(GeodesicTracing, SeveralLengthsGiveTheEndsOfEach)
{
  const Traced surface(test::BumpySurface(3));
  const Traced plane(test::PlanePatch(8, 8));
  constexpr std::array<double, 5> lengths{ 0.0, 0.03, 0.3, 0.3, 1.7 };
  for (const Traced* traced : { &surface, &plane })
  {
    for (Index f = 0; f < traced->Mesh.NumberOfTriangles(); f += 31)
    {
      const Eigen::Vector3d direction = traced->Direction(f, 0.7 * f);
      std::array<GeodesicEnd, 5> ends;
      traced->Tracer.Trace({ f, Middle }, direction, 5, lengths.data(), ends.data());
      for (std::size_t k = 0; k < lengths.size(); ++k)
      {
        const GeodesicEnd alone = traced->Tracer.Trace({ f, Middle }, direction, lengths[k]);
        EXPECT_EQ(ends[k].Place.Triangle, alone.Place.Triangle);
        EXPECT_EQ(ends[k].Place.Weights, alone.Place.Weights);
        EXPECT_EQ(ends[k].Direction, alone.Direction);
        EXPECT_EQ(ends[k].IsComplete, alone.IsComplete);
      }
    }
  }
}

TEST(GeodesicTracing, ATriangleWoundTheOtherWayEndsThem)
{
  TriangleMesh mesh = test::PlanePatch(1, 1);
  ASSERT_EQ(mesh.NumberOfTriangles(), 2);
  std::swap(mesh.Triangles(1, 0), mesh.Triangles(1, 1));
  const Traced square(std::move(mesh));
  const Eigen::Vector3d start = PositionOf(square.Mesh, { 0, Middle });
  const Eigen::Vector3d beyond = PositionOf(square.Mesh, { 1, Middle });
  const GeodesicEnd end = square.Tracer.Trace({ 0, Middle }, (beyond - start).normalized(), (beyond - start).norm());
  EXPECT_FALSE(end.IsComplete);
  EXPECT_EQ(end.Place.Triangle, 0);
}
