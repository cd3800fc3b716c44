// SPDX-License-Identifier: BSD-3-Clause
// Midpoint subdivision: the published order, on meshes that are open, closed and not manifold.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/EdgeSplits.h"
#include "Core/Mesh/HalfEdges.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Operators/SurfaceOperators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

using namespace surfsynth;

namespace
{
/// The definition, with a table of edges.
SubdividedMesh Defined(const TriangleMesh& mesh)
{
  SubdividedMesh result;
  const Index faces = mesh.NumberOfTriangles();
  std::map<std::pair<Index, Index>, Index> midpoints;
  result.Mesh.Triangles.resize(4 * faces, 3);
  for (Index f = 0; f < faces; ++f)
  {
    Index m[3];
    for (int k = 0; k < 3; ++k)
    {
      const Index a = mesh.Triangles(f, k);
      const Index b = mesh.Triangles(f, (k + 1) % 3);
      const auto next = static_cast<Index>(mesh.NumberOfPoints() + result.Parents.size());
      const auto added = midpoints.emplace(std::minmax(a, b), next);
      m[k] = added.first->second;
      if (added.second)
      {
        result.Parents.push_back({ a, b });
      }
    }
    for (int k = 0; k < 3; ++k)
    {
      result.Mesh.Triangles.row(f + k * faces) << mesh.Triangles(f, k), m[k], m[(k + 2) % 3];
    }
    result.Mesh.Triangles.row(f + 3 * faces) << m[0], m[1], m[2];
  }
  result.Mesh.Points.resize(mesh.NumberOfPoints() + static_cast<Index>(result.Parents.size()), 3);
  result.Mesh.Points.topRows(mesh.NumberOfPoints()) = mesh.Points;
  for (std::size_t e = 0; e < result.Parents.size(); ++e)
  {
    result.Mesh.Points.row(mesh.NumberOfPoints() +
      static_cast<Index>(e)) = (mesh.Points.row(result.Parents[e][0]) + mesh.Points.row(result.Parents[e][1])) / 2.0;
  }
  return result;
}

void ExpectAsDefined(const TriangleMesh& mesh)
{
  const SubdividedMesh found = SubdivideAtMidpoints(mesh);
  const SubdividedMesh expected = Defined(mesh);
  EXPECT_EQ(found.Mesh.Triangles, expected.Mesh.Triangles);
  EXPECT_EQ(found.Parents, expected.Parents);
  EXPECT_EQ(found.Mesh.Points, expected.Mesh.Points);
}

/// Three triangles on the edge 0 1.
TriangleMesh Fan()
{
  TriangleMesh fan;
  fan.Points.resize(5, 3);
  fan.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1;
  fan.Triangles.resize(3, 3);
  fan.Triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  return fan;
}

class SubdivisionOfSuite : public testing::TestWithParam<std::string>
{};
INSTANTIATE_TEST_SUITE_P(
  Suite, SubdivisionOfSuite, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });
} // namespace

TEST(MidpointSubdivision, OfOneTriangleIsAsPublished)
{
  const SubdividedMesh four = SubdivideAtMidpoints(test::SingleTriangle());
  TriangleMatrix triangles(4, 3);
  triangles << 0, 3, 5, 1, 4, 3, 2, 5, 4, 3, 4, 5;
  EXPECT_EQ(four.Mesh.Triangles, triangles);
  PointMatrix midpoints(3, 3);
  midpoints << 1, 0, 0, 1, 0.5, 0, 0, 0.5, 0;
  EXPECT_EQ(four.Mesh.Points.bottomRows(3), midpoints);
}

TEST_P(SubdivisionOfSuite, HasThePublishedOrderAndTheSameArea)
{
  const test::SuiteMesh& suite = test::FromSuite(GetParam());
  ExpectAsDefined(suite.Mesh);
  const TriangleMesh fine = SubdivideAtMidpoints(suite.Mesh).Mesh;
  const double area = FaceAreas(suite.Mesh).sum();
  EXPECT_NEAR(FaceAreas(fine).sum(), area, 1e-12 * area);
  MeshRequirements requirements;
  requirements.Closed = suite.Closed;
  requirements.ConsistentWinding = suite.ConsistentWinding;
  EXPECT_TRUE(CheckMesh(fine, requirements).empty());
}

TEST(MidpointSubdivision, AnEdgeOfThreeTrianglesHasOneMidpoint)
{
  ExpectAsDefined(Fan());
  EXPECT_EQ(SubdivideAtMidpoints(Fan()).Mesh.NumberOfPoints(), 5 + 7);
}

TEST(MidpointSubdivision, RowsAreInterpolatedAsPointsAre)
{
  const TriangleMesh mesh = test::Icosphere(2);
  const SubdividedMesh fine = SubdivideAtMidpoints(mesh);
  EXPECT_EQ(InterpolateAtMidpoints(mesh.Points, fine.Parents), fine.Mesh.Points);
  const Eigen::VectorXd column = mesh.Points.col(1);
  EXPECT_EQ(InterpolateAtMidpoints(column, fine.Parents), fine.Mesh.Points.col(1));
  EXPECT_EQ(InterpolateAtMidpoints(Eigen::VectorXf(), fine.Parents).size(), 0) << "none stay none";
}

TEST(MidpointSubdivision, OfNothingIsNothing)
{
  const SubdividedMesh nothing = SubdivideAtMidpoints({});
  EXPECT_EQ(nothing.Mesh.NumberOfPoints(), 0);
  EXPECT_EQ(nothing.Mesh.NumberOfTriangles(), 0);
}

TEST(MidpointSubdivision, IsTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::Icosphere(6);
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    return SubdivideAtMidpoints(mesh);
  };
  const SubdividedMesh one = with(1);
  const SubdividedMesh three = with(3);
  EXPECT_EQ(one.Mesh.Triangles, three.Mesh.Triangles);
  EXPECT_EQ(one.Mesh.Points, three.Mesh.Points);
}

TEST(EdgeSplits, OfAllEdgesAreTheSubdivisionAndOfNoneTheMesh)
{
  const TriangleMesh mesh = test::IrregularSphere(1);
  const SubdividedMesh all = SplitEdges(mesh, [](std::int64_t) { return true; });
  EXPECT_EQ(all.Mesh.NumberOfPoints(), SubdivideAtMidpoints(mesh).Mesh.NumberOfPoints());
  EXPECT_EQ(all.Mesh.NumberOfTriangles(), 4 * mesh.NumberOfTriangles());
  const SubdividedMesh none = SplitEdges(mesh, [](std::int64_t) { return false; });
  EXPECT_TRUE(none.Mesh.Triangles == mesh.Triangles && none.Mesh.Points == mesh.Points);
  EXPECT_TRUE(none.Parents.empty());
}

TEST(EdgeSplits, OfSomeEdgesKeepTheSurface)
{
  const auto characteristic = [](const TriangleMesh& mesh) {
    return mesh.NumberOfPoints() - EdgeGroups(mesh).NumberOfEdges() + mesh.NumberOfTriangles();
  };
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  TriangleMesh open = test::IrregularSphere(2);
  open.Triangles.conservativeResize(open.Triangles.rows() - 30, 3);
  for (const TriangleMesh& mesh : { test::IrregularSphere(2), open })
  {
    for (int tenths = 1; tenths < 10; ++tenths)
    {
      const SubdividedMesh split = SplitEdges(mesh, [&](std::int64_t edge) {
        return test::Uniform(tenths, static_cast<std::uint64_t>(edge)) < 0.2 * tenths - 1.0; // of numbers from -1 to 1
      });
      EXPECT_GT(split.Parents.size(), 0U);
      EXPECT_EQ(split.Mesh.NumberOfPoints(), mesh.NumberOfPoints() + static_cast<Index>(split.Parents.size()));
      EXPECT_EQ(characteristic(split.Mesh), characteristic(mesh));
      EXPECT_TRUE(CheckMesh(split.Mesh, requirements).empty());
      EXPECT_NEAR(SurfaceArea(split.Mesh), SurfaceArea(mesh), 1e-12 * SurfaceArea(mesh));
    }
  }
}

TEST(MidpointSubdivision, BrokenIdsAreRefused)
{
  TriangleMesh mesh = test::SingleTriangle();
  mesh.Triangles(0, 1) = 3;
  EXPECT_THROW(SubdivideAtMidpoints(mesh), InvalidInput);
  mesh.Triangles(0, 1) = -1;
  EXPECT_THROW(SubdivideAtMidpoints(mesh), InvalidInput);
  mesh.Triangles(0, 1) = 0;
  EXPECT_THROW(SubdivideAtMidpoints(mesh), InvalidInput);
}
