// SPDX-License-Identifier: BSD-3-Clause
// Edge features of triangles: by hand, under motions, at boundaries, at vertices of any degree.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Operators/EdgeFeatures.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{
/// The triangle (0,0,0), (2,0,0), (0,2,0), and one beyond its first edge with the corner (1, -1, 1).
TriangleMesh Pair()
{
  TriangleMesh pair;
  pair.Points.resize(4, 3);
  pair.Points << 0, 0, 0, 2, 0, 0, 0, 2, 0, 1, -1, 1;
  pair.Triangles.resize(2, 3);
  pair.Triangles << 0, 1, 2, 3, 1, 0;
  return pair;
}

EdgeFeatureMatrix Features(const TriangleMesh& mesh)
{
  return ComputeEdgeFeatures(mesh.Points.cast<float>(), mesh.Triangles, ComputeFaceNeighbors(mesh));
}

SinglePoints Numbers(Eigen::Index rows, std::uint64_t seed)
{
  SinglePoints numbers(rows, 3);
  for (Eigen::Index k = 0; k < numbers.size(); ++k)
  {
    numbers.data()[k] = static_cast<float>(test::Uniform(seed, static_cast<std::uint64_t>(k)));
  }
  return numbers;
}

const Eigen::Matrix3d& Rotation()
{
  static const Eigen::Matrix3d rotation =
    Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  return rotation;
}
} // namespace

TEST(EdgeFeatures, OfAPairAreAsByHand)
{
  const EdgeFeatureMatrix features = Features(Pair());
  const float half = std::sqrt(0.5F);
  Eigen::Matrix<float, 1, 12> expected;
  // Edge 0: the corner beyond, from the midpoint (1, 0, 0): (0, -1, 1), along x, -y (outward) and z.
  // Edge 1: its own corner (0,0,0), turned around (1, 1, 0) to (2, 2, 0), along (-1,1,0) and (1,1,0) over sqrt 2.
  // Edge 2: its own corner (2,0,0), turned around (0, 1, 0) to (-2, 2, 0), along -y and -x.
  expected << 0, 1, 1, 2, 0, 2 * half, 0, 4 * half, -1, 2, 0, 2;
  EXPECT_LE((features.row(0) - expected).cwiseAbs().maxCoeff(), 1e-6F) << features.row(0);
}

TEST(EdgeFeatures, OfRegularNeighborsInAPlaneAreTheHeight)
{
  // Two equilateral triangles of side 1: the corner beyond lies above the midpoint at the height, beyond boundaries too.
  TriangleMesh rhombus;
  rhombus.Points.resize(4, 3);
  rhombus.Points << 0, 0, 0, 1, 0, 0, 0.5, std::sqrt(0.75), 0, 0.5, -std::sqrt(0.75), 0;
  rhombus.Triangles.resize(2, 3);
  rhombus.Triangles << 0, 1, 2, 1, 0, 3;
  const EdgeFeatureMatrix features = Features(rhombus);
  for (int f = 0; f < 2; ++f)
  {
    for (int k = 0; k < 12; k += 4)
    {
      EXPECT_NEAR(features(f, k), 0.0F, 1e-6F);
      EXPECT_NEAR(features(f, k + 1), std::sqrt(0.75F), 1e-6F);
      EXPECT_NEAR(features(f, k + 2), 0.0F, 1e-6F);
      EXPECT_NEAR(features(f, k + 3), 1.0F, 1e-6F);
    }
  }
}

TEST(EdgeFeatures, BeyondABoundaryLiesTheTriangleItself)
{
  const FaceNeighbors neighbors = ComputeFaceNeighbors(Pair());
  TriangleMatrix faces(2, 3);
  faces << 1, 0, 0, 1, 0, 1;
  TriangleMatrix opposite(2, 3);
  opposite << 3, 0, 1, 0, 2, 1;
  EXPECT_EQ(neighbors.Faces, faces);
  EXPECT_EQ(neighbors.Opposite, opposite);
}

TEST(EdgeFeatures, NeighborsOfClosedMeshesAreMutual)
{
  for (const TriangleMesh& mesh : { test::Torus(12, 9), test::UvSphere(5, 30), test::Tetrahedron() })
  {
    const FaceNeighbors neighbors = ComputeFaceNeighbors(mesh);
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      for (int edge = 0; edge < 3; ++edge)
      {
        const Index g = neighbors.Faces(f, edge);
        ASSERT_NE(g, f);
        EXPECT_TRUE((neighbors.Faces.row(g).array() == f).any());
        EXPECT_TRUE((mesh.Triangles.row(g).array() == mesh.Triangles(f, edge)).any());
        EXPECT_TRUE((mesh.Triangles.row(g).array() == mesh.Triangles(f, (edge + 1) % 3)).any());
        EXPECT_FALSE((mesh.Triangles.row(f).array() == neighbors.Opposite(f, edge)).any());
      }
    }
  }
}

TEST(EdgeFeatures, AnEdgeOfThreeTrianglesIsRefused)
{
  TriangleMesh fan = Pair();
  fan.Triangles.conservativeResize(3, 3);
  fan.Triangles.row(2) << 0, 1, 3;
  try
  {
    ComputeFaceNeighbors(fan);
    ADD_FAILURE() << "accepted";
  }
  catch (const InvalidInput& error)
  {
    EXPECT_THAT(error.what(), HasSubstr("three triangles or more"));
  }
}

TEST(EdgeFeatures, DoNotChangeUnderMotions)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  TriangleMesh moved = mesh;
  moved.Points = (mesh.Points * Rotation().transpose()).rowwise() + Eigen::RowVector3d(0.5, -1.0, 2.0);
  EXPECT_LE((Features(moved) - Features(mesh)).cwiseAbs().maxCoeff(), 2e-6F);
}

TEST(EdgeFeatures, OfTrianglesWithoutAreaAreFinite)
{
  TriangleMesh flat = Pair();
  flat.Points.row(2) << 1, 0, 0;
  flat.Points.row(3) << 2, 0, 0;
  EXPECT_TRUE(Features(flat).allFinite());
  EXPECT_TRUE(MeanCornerDisplacement(flat.Points.cast<float>(), flat.Triangles, Numbers(2, 1)).allFinite());
}

TEST(MeanCornerDisplacement, OfAPairIsAsByHand)
{
  const TriangleMesh pair = Pair();
  SinglePoints local(2, 3);
  local << 1, 2, 3, 0, 0, 0;
  const SinglePoints moved = MeanCornerDisplacement(pair.Points.cast<float>(), pair.Triangles, local);
  const float half = std::sqrt(0.5F);
  SinglePoints expected(4, 3);
  // Corner k: x_k + 2 y_k + 3 n. Vertices 0 and 1 have a second triangle, which moves nothing.
  expected << 0.5, -1, 1.5, (-half + 2 * half) / 2, (half + 2 * half) / 2, 1.5, -2, -1, 3, 0, 0, 0;
  EXPECT_LE((moved - expected).cwiseAbs().maxCoeff(), 1e-6F) << moved;
}

TEST(MeanCornerDisplacement, TurnsWithTheMeshAndIsLinear)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  TriangleMesh turned = mesh;
  turned.Points = mesh.Points * Rotation().transpose();
  const SinglePoints local = Numbers(mesh.Triangles.rows(), 2);
  const SinglePoints still = MeanCornerDisplacement(mesh.Points.cast<float>(), mesh.Triangles, local);
  const SinglePoints moved = MeanCornerDisplacement(turned.Points.cast<float>(), mesh.Triangles, local);
  EXPECT_LE((moved - still * Rotation().transpose().cast<float>()).cwiseAbs().maxCoeff(), 2e-5F);
  const SinglePoints twice = MeanCornerDisplacement(
    mesh.Points.cast<float>(), mesh.Triangles, SinglePoints(2.0F * local));
  EXPECT_LE((twice - 2.0F * still).cwiseAbs().maxCoeff(), 1e-6F);
}

TEST(MeanCornerDisplacement, AtAPoleOfThirtyTrianglesIsTheirMean)
{
  // Every triangle pushes along its normal: the pole of a symmetric globe moves along the axis.
  const TriangleMesh globe = test::UvSphere(5, 30);
  SinglePoints local = SinglePoints::Zero(globe.Triangles.rows(), 3);
  local.col(2).setOnes();
  const SinglePoints moved = MeanCornerDisplacement(globe.Points.cast<float>(), globe.Triangles, local);
  int poles = 0;
  for (Index v = 0; v < globe.NumberOfPoints(); ++v)
  {
    const auto degree = (globe.Triangles.array() == v).count();
    if (degree == 30)
    {
      ++poles;
      EXPECT_NEAR(moved.row(v).head(2).norm(), 0.0F, 1e-5F);
      EXPECT_NEAR(globe.Points.row(v).normalized().dot(moved.row(v).normalized().cast<double>()), 1.0, 1e-5);
    }
  }
  EXPECT_EQ(poles, 2);
}

TEST(MeanCornerDisplacement, LeavesUnusedVerticesAlone)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::Icosphere(1));
  const SinglePoints moved = MeanCornerDisplacement(
    mesh.Points.cast<float>(), mesh.Triangles, Numbers(mesh.Triangles.rows(), 3));
  EXPECT_EQ(moved.row(0).norm(), 0.0F);
  EXPECT_GT(moved.row(1).norm(), 0.0F);
}

TEST(EdgeFeatures, AreTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::Icosphere(5);
  const SinglePoints local = Numbers(mesh.Triangles.rows(), 4);
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    return std::make_pair(Features(mesh), MeanCornerDisplacement(mesh.Points.cast<float>(), mesh.Triangles, local));
  };
  const auto one = with(1);
  const auto two = with(2);
  EXPECT_EQ(one.first, two.first);
  EXPECT_EQ(one.second, two.second);
}
