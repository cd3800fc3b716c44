// SPDX-License-Identifier: BSD-3-Clause
//
// SeparateSheets() and RemoveDegenerateTriangles(): manifold results, the solid unchanged.
#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SeparateSheets.h"
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <set>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
using Voxels = std::set<UnitCube>;

Voxels Noise(int side, std::uint32_t seed)
{
  Voxels voxels;
  for (int k = 0; k < side * side * side; ++k)
  {
    if (Mix(seed, static_cast<std::uint64_t>(k)) % 2 == 0)
    {
      voxels.insert({ { k % side, k / side % side, k / side / side } });
    }
  }
  return voxels;
}

Index ComponentsOf(const TriangleMesh& mesh)
{
  return ComputeComponents(MeshTopology(mesh), Eigen::VectorXd::Zero(mesh.NumberOfPoints())).Count;
}

void ExpectSeparated(const TriangleMesh& mesh)
{
  const TriangleMesh result = SeparateSheets(mesh);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_NEAR(VolumeOf(result), VolumeOf(mesh), 1e-9 * std::abs(VolumeOf(mesh)));
}
} // namespace

TEST(SeparateSheets, LeavesValidMeshesAsTheyAre)
{
  for (const TriangleMesh& mesh :
    { Icosphere(2), Torus(20, 12), Join(Icosphere(1), Translated(Icosphere(1), { 3, 0, 0 })) })
  {
    const TriangleMesh result = SeparateSheets(mesh);
    EXPECT_EQ(result.Points, mesh.Points);
    EXPECT_EQ(result.Triangles, mesh.Triangles);
  }
}

TEST(SeparateSheets, CubesThatTouchInAnEdgeBecomeTwoParts)
{
  const TriangleMesh touching = SurfaceOfCubes({ { { 0, 0, 0 } }, { { 1, 1, 0 } } });
  ASSERT_NE(DefectsOf(touching), "");
  const TriangleMesh result = SeparateSheets(touching);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_EQ(result.NumberOfPoints(), 16);
  EXPECT_EQ(result.NumberOfTriangles(), 24);
  EXPECT_EQ(ComponentsOf(result), 2);
  EXPECT_NEAR(VolumeOf(result), 2.0, 1e-12);
}

TEST(SeparateSheets, CubesThatTouchInACornerBecomeTwoParts)
{
  const TriangleMesh touching = SurfaceOfCubes({ { { 0, 0, 0 } }, { { 1, 1, 1 } } });
  ASSERT_NE(DefectsOf(touching), "");
  const TriangleMesh result = SeparateSheets(touching);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_EQ(result.NumberOfPoints(), 16);
  EXPECT_EQ(ComponentsOf(result), 2);
}

TEST(SeparateSheets, AnEdgeThatOneFanPassesTwiceAtEitherEndGetsAPoint)
{
  // Two full layers and between them two cubes that touch in an edge: its ends are single fans.
  Voxels voxels;
  for (const int z : { 0, 2 })
  {
    voxels.insert({ { { 0, 0, z } }, { { 1, 0, z } }, { { 0, 1, z } }, { { 1, 1, z } } });
  }
  voxels.insert({ { 0, 0, 1 } });
  voxels.insert({ { 1, 1, 1 } });
  const TriangleMesh pinched = SurfaceOfCubes(voxels);
  ASSERT_NE(DefectsOf(pinched), "");
  const TriangleMesh result = SeparateSheets(pinched);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_EQ(ComponentsOf(result), 1);
  EXPECT_EQ(result.NumberOfPoints(), pinched.NumberOfPoints() + 1);
  EXPECT_EQ(result.NumberOfTriangles(), pinched.NumberOfTriangles() + 2);
  EXPECT_EQ(result.Points.row(result.NumberOfPoints() - 1), Eigen::RowVector3d(1.0, 1.0, 1.5));
  EXPECT_NEAR(VolumeOf(result), 10.0, 1e-12);
}

TEST(SeparateSheets, BoundariesOfRandomVoxelsBecomeManifold)
{
  for (std::uint32_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    ExpectSeparated(SurfaceOfCubes(Noise(static_cast<int>(2 + seed / 2), seed)));
  }
}

TEST(SeparateSheets, DropsSheetsWithoutThickness)
{
  TriangleMesh sheet;
  sheet.Points = SingleTriangle().Points;
  sheet.Triangles.resize(2, 3);
  sheet.Triangles << 0, 1, 2, 0, 2, 1;
  EXPECT_EQ(SeparateSheets(sheet).NumberOfTriangles(), 0);
  const TriangleMesh result = SeparateSheets(Join(Icosphere(1), sheet));
  EXPECT_EQ(result.NumberOfTriangles(), Icosphere(1).NumberOfTriangles());
  EXPECT_EQ(DefectsOf(result), "");
}

TEST(SeparateSheets, AMeshOnItselfTwiceBecomesManifold)
{
  TriangleMesh twice = Icosphere(1);
  const TriangleMatrix once = twice.Triangles;
  twice.Triangles.resize(2 * once.rows(), 3);
  twice.Triangles << once, once;
  const TriangleMesh result = SeparateSheets(twice);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_NEAR(VolumeOf(result), 2.0 * VolumeOf(Icosphere(1)), 1e-12);
}

TEST(SeparateSheets, NamesTheEdgeThatIsNotBalanced)
{
  const auto messageOf = [](const TriangleMesh& mesh) -> std::string {
    try
    {
      SeparateSheets(mesh);
    }
    catch (const InvalidInput& error)
    {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(messageOf(SingleTriangle()), ::testing::HasSubstr("3 edge(s) have not as many triangles"));
  EXPECT_THAT(messageOf(MoebiusStrip(12, 2)), ::testing::HasSubstr("closed and consistently wound"));
  TriangleMesh outside = Icosphere(0);
  outside.Triangles(5, 1) = 12;
  EXPECT_THAT(messageOf(outside), ::testing::HasSubstr("triangle 5 names a point that does not exist"));
}

TEST(SeparateSheets, GivesTheSameBitsForEveryNumberOfThreads)
{
  const TriangleMesh mesh = SurfaceOfCubes(Noise(24, 7));
  const ThreadScope one(1);
  const TriangleMesh expected = SeparateSheets(mesh);
  for (const int threads : { 2, 5 })
  {
    const ThreadScope several(threads);
    const TriangleMesh result = SeparateSheets(mesh);
    EXPECT_EQ(result.Points, expected.Points);
    EXPECT_EQ(result.Triangles, expected.Triangles);
  }
}

TEST(RemoveDegenerateTriangles, LeavesValidMeshesAsTheyAre)
{
  const TriangleMesh mesh = Torus(20, 12);
  const TriangleMesh result = RemoveDegenerateTriangles(mesh);
  EXPECT_EQ(result.Points, mesh.Points);
  EXPECT_EQ(result.Triangles, mesh.Triangles);
}

TEST(RemoveDegenerateTriangles, ContractsEdgesWithoutLength)
{
  TriangleMesh mesh = Icosphere(2);
  mesh.Points.row(mesh.Triangles(7, 1)) = mesh.Points.row(mesh.Triangles(7, 0));
  ASSERT_NE(DefectsOf(mesh), "");
  const TriangleMesh result = RemoveDegenerateTriangles(mesh);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_EQ(result.NumberOfPoints(), mesh.NumberOfPoints() - 1);
  EXPECT_EQ(result.NumberOfTriangles(), mesh.NumberOfTriangles() - 2);
  EXPECT_NEAR(VolumeOf(result), VolumeOf(mesh), 1e-12);
}

TEST(RemoveDegenerateTriangles, FlipsTheEdgeOnWhichTheOppositeCornerLies)
{
  // A tetrahedron with a point in the middle of an edge, which only one of the triangles there knows.
  TriangleMesh mesh = Tetrahedron();
  const Index a = mesh.Triangles(0, 0), b = mesh.Triangles(0, 1), c = mesh.Triangles(0, 2);
  mesh.Points.conservativeResize(5, 3);
  mesh.Points.row(4) = 0.5 * (mesh.Points.row(a) + mesh.Points.row(b));
  const TriangleMatrix before = mesh.Triangles;
  mesh.Triangles.resize(6, 3);
  mesh.Triangles << a, 4, c, 4, b, c, a, b, 4, before.bottomRows(3);
  ASSERT_THAT(DefectsOf(mesh), ::testing::HasSubstr("degenerate"));
  const TriangleMesh result = RemoveDegenerateTriangles(mesh);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_EQ(result.NumberOfPoints(), 5);
  EXPECT_EQ(result.NumberOfTriangles(), 6);
  EXPECT_NEAR(VolumeOf(result), VolumeOf(Tetrahedron()), 1e-12);
}

TEST(RemoveDegenerateTriangles, ASolidWithoutVolumeVanishes)
{
  TriangleMesh mesh = Icosphere(1);
  mesh.Points.setConstant(1.25);
  EXPECT_EQ(RemoveDegenerateTriangles(mesh).NumberOfTriangles(), 0);
  mesh = Icosphere(1);
  mesh.Points.rightCols(2).setZero(); // on a line
  EXPECT_EQ(RemoveDegenerateTriangles(mesh).NumberOfTriangles(), 0);
}

TEST(RemoveDegenerateTriangles, RoundedPointsOfRandomVoxelsLeaveNoDefect)
{
  // Coordinates that coincide by thirds: needles, caps and flat parts of all kinds.
  for (std::uint32_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    TriangleMesh mesh = SurfaceOfCubes(Noise(6, seed));
    mesh.Points = (mesh.Points.array() / 3.0).floor() * 3.0;
    EXPECT_EQ(DefectsOf(SeparateSheets(RemoveDegenerateTriangles(mesh))), "");
  }
}
