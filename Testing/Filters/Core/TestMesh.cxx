// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

using namespace surfsynth;

namespace
{

constexpr double Pi = 3.14159265358979323846;

class MeshOfSuite : public testing::TestWithParam<std::string>
{
protected:
  const test::SuiteMesh& Case = test::FromSuite(GetParam());
  const TriangleMesh& Mesh = Case.Mesh;
};

INSTANTIATE_TEST_SUITE_P(
  Suite, MeshOfSuite, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

// --- BoundingBox, ContentHash -----------------------------------------------------------------------------------

TEST(BoundingBox, IsThatOfTheUsedPoints)
{
  TriangleMesh mesh = test::PlanePatch(3, 2, 6.0, 4.0);
  mesh = test::Translated(mesh, { -1.0, 10.0, 2.0 });
  mesh = test::WithUnreferencedPoints(mesh); // at (17, 17, 17)
  const BoundingBox box = ComputeBoundingBox(mesh);
  EXPECT_EQ(box.Lower, Eigen::Vector3d(-1.0, 10.0, 2.0));
  EXPECT_EQ(box.Upper, Eigen::Vector3d(5.0, 14.0, 2.0));
  EXPECT_EQ(box.LongestSide(), 6.0);
}

TEST(BoundingBox, IsZeroWithoutTriangles)
{
  TriangleMesh mesh;
  EXPECT_EQ(ComputeBoundingBox(mesh).LongestSide(), 0.0);
  mesh.Points = PointMatrix::Constant(4, 3, 5.0);
  mesh.Triangles.resize(0, 3);
  const BoundingBox box = ComputeBoundingBox(mesh);
  EXPECT_EQ(box.Lower, Eigen::Vector3d::Zero());
  EXPECT_EQ(box.Upper, Eigen::Vector3d::Zero());
}

TEST(ContentHash, IsEqualForEqualMeshes)
{
  EXPECT_EQ(ContentHash(test::Icosphere(3)), ContentHash(test::Icosphere(3)));
  EXPECT_EQ(ContentHash(TriangleMesh()), ContentHash(TriangleMesh()));
}

TEST(ContentHash, ChangesWithTheLowestBitOfEveryCoordinateAndId)
{
  TriangleMesh mesh = test::Icosphere(1);
  std::set<std::uint64_t> seen = { ContentHash(mesh) };
  std::size_t changes = 1;
  for (Eigen::Index i = 0; i < mesh.Points.size(); ++i, ++changes)
  {
    double& coordinate = mesh.Points.data()[i];
    const double before = coordinate;
    coordinate = std::nextafter(before, 10.0);
    seen.insert(ContentHash(mesh));
    coordinate = before;
  }
  for (Eigen::Index i = 0; i < mesh.Triangles.size(); ++i, ++changes)
  {
    mesh.Triangles.data()[i] ^= 1;
    seen.insert(ContentHash(mesh));
    mesh.Triangles.data()[i] ^= 1;
  }
  EXPECT_EQ(seen.size(), changes);
}

TEST(ContentHash, ChangesWithTheOrderOfPointsAndTriangles)
{
  const TriangleMesh mesh = test::Icosphere(1);
  std::set<std::uint64_t> seen = { ContentHash(mesh) };
  std::size_t changes = 1;
  for (Index i = 0; i < mesh.NumberOfPoints(); ++i)
  {
    for (Index j = 0; j < i; ++j, ++changes)
    {
      TriangleMesh swapped = mesh;
      swapped.Points.row(i).swap(swapped.Points.row(j));
      seen.insert(ContentHash(swapped));
    }
  }
  for (Index i = 0; i < mesh.NumberOfTriangles(); ++i)
  {
    for (Index j = 0; j < i; ++j, ++changes)
    {
      TriangleMesh swapped = mesh;
      swapped.Triangles.row(i).swap(swapped.Triangles.row(j));
      seen.insert(ContentHash(swapped));
    }
  }
  EXPECT_EQ(seen.size(), changes);
}

TEST(ContentHash, ChangesWhenZerosAreAppended)
{
  TriangleMesh mesh = test::Tetrahedron();
  std::set<std::uint64_t> seen = { ContentHash(mesh) };
  for (int i = 0; i < 20; ++i)
  {
    mesh.Points.conservativeResize(mesh.Points.rows() + 1, 3);
    mesh.Points.bottomRows(1).setZero();
    seen.insert(ContentHash(mesh));
    mesh.Triangles.conservativeResize(mesh.Triangles.rows() + 1, 3);
    mesh.Triangles.bottomRows(1).setZero();
    seen.insert(ContentHash(mesh));
  }
  EXPECT_EQ(seen.size(), 41U);
}

// --- MeshTopology -----------------------------------------------------------------------------------------------

TEST_P(MeshOfSuite, TopologyAgreesWithBruteForce)
{
  const auto points = static_cast<std::size_t>(this->Mesh.NumberOfPoints());
  std::vector<std::vector<Index>> triangles(points);
  std::vector<std::map<Index, int>> neighbors(points);
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    for (int c = 0; c < 3; ++c)
    {
      const Index v = this->Mesh.Triangles(f, c);
      triangles[static_cast<std::size_t>(v)].push_back(f);
      ++neighbors[static_cast<std::size_t>(v)][this->Mesh.Triangles(f, (c + 1) % 3)];
      ++neighbors[static_cast<std::size_t>(v)][this->Mesh.Triangles(f, (c + 2) % 3)];
    }
  }
  const MeshTopology topology(this->Mesh);
  ASSERT_EQ(topology.NumberOfPoints(), this->Mesh.NumberOfPoints());
  ASSERT_EQ(topology.VertexTriangleStart.front(), 0);
  ASSERT_EQ(topology.NeighborStart.front(), 0);
  std::int64_t edges = 0;
  for (std::size_t v = 0; v < points; ++v)
  {
    const std::vector<Index> around(topology.VertexTriangles.begin() + topology.VertexTriangleStart[v],
      topology.VertexTriangles.begin() + topology.VertexTriangleStart[v + 1]);
    EXPECT_EQ(around, triangles[v]) << "vertex " << v;
    std::map<Index, int> joined;
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      const auto at = static_cast<std::size_t>(k);
      EXPECT_TRUE(k == topology.NeighborStart[v] || topology.Neighbors[at - 1] < topology.Neighbors[at]);
      joined[topology.Neighbors[at]] = topology.EdgeTriangles[at];
    }
    EXPECT_EQ(joined, neighbors[v]) << "vertex " << v;
    edges += static_cast<std::int64_t>(joined.size());
  }
  EXPECT_EQ(topology.NumberOfEdges(), edges / 2);
}

TEST(MeshTopology, IsTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::Icosphere(6); // above any sensible grain
  const ThreadScope one(1);
  const MeshTopology reference(mesh);
  for (const int threads : { 2, 3 })
  {
    const ThreadScope scope(threads);
    const MeshTopology topology(mesh);
    EXPECT_EQ(topology.VertexTriangleStart, reference.VertexTriangleStart);
    EXPECT_EQ(topology.VertexTriangles, reference.VertexTriangles);
    EXPECT_EQ(topology.NeighborStart, reference.NeighborStart);
    EXPECT_EQ(topology.Neighbors, reference.Neighbors);
    EXPECT_EQ(topology.EdgeTriangles, reference.EdgeTriangles);
  }
}

TEST(MeshTopology, CountsTrianglesOnNonManifoldEdges)
{
  // A fan of 300 triangles around the edge 0-1.
  TriangleMesh mesh;
  mesh.Points.resize(302, 3);
  mesh.Points.setRandom();
  mesh.Triangles.resize(300, 3);
  for (Index f = 0; f < 300; ++f)
  {
    mesh.Triangles.row(f) << 0, 1, f + 2;
  }
  const MeshTopology topology(mesh);
  ASSERT_EQ(topology.Neighbors[0], 1);
  EXPECT_EQ(topology.EdgeTriangles[0], 255) << "the count saturates";
  mesh.Triangles.conservativeResize(3, 3);
  EXPECT_EQ(MeshTopology(mesh).EdgeTriangles[0], 3);
}

TEST(MeshTopology, RejectsIdsOutOfRangeAndRepeatedVertices)
{
  for (const Index bad : { -1, 4, std::numeric_limits<Index>::max(), std::numeric_limits<Index>::min() })
  {
    TriangleMesh mesh = test::Tetrahedron();
    mesh.Triangles(2, 1) = bad;
    EXPECT_THROW(MeshTopology{ mesh }, InvalidInput) << bad;
  }
  TriangleMesh mesh = test::Tetrahedron();
  mesh.Triangles(2, 1) = mesh.Triangles(2, 0);
  EXPECT_THROW(MeshTopology{ mesh }, InvalidInput);
}

TEST(MeshTopology, OfAnEmptyMeshIsEmpty)
{
  const MeshTopology topology{ TriangleMesh() };
  EXPECT_EQ(topology.NumberOfPoints(), 0);
  EXPECT_EQ(topology.NumberOfEdges(), 0);
}

// --- MeshComponents ---------------------------------------------------------------------------------------------

TEST_P(MeshOfSuite, ComponentsHaveTheKnownTopology)
{
  const MeshTopology topology(this->Mesh);
  const Eigen::VectorXd mass = LumpedMass(this->Mesh, topology);
  const MeshComponents components = ComputeComponents(topology, mass);
  ASSERT_EQ(components.Count, this->Case.Components);
  ASSERT_EQ(components.Area.size(), static_cast<std::size_t>(components.Count));
  ASSERT_EQ(components.Closed.size(), static_cast<std::size_t>(components.Count));
  EXPECT_EQ(std::accumulate(components.EulerCharacteristic.begin(), components.EulerCharacteristic.end(), 0L),
    this->Case.EulerCharacteristic);
  EXPECT_EQ(std::count(components.Closed.begin(), components.Closed.end(), false) == 0, this->Case.Closed);
  EXPECT_EQ(std::count(components.OfVertex.begin(), components.OfVertex.end(), -1), this->Case.UnusedPoints);
  EXPECT_NEAR(std::accumulate(components.Area.begin(), components.Area.end(), 0.0), FaceAreas(this->Mesh).sum(),
    1e-12 * mass.sum());
}

TEST(MeshComponents, AreNumberedByTheirLowestVertex)
{
  const TriangleMesh ball = test::Translated(test::Icosphere(4), { 9.0, 0.0, 0.0 });
  const TriangleMesh mesh = test::WithUnreferencedPoints(
    test::Join(test::Join(test::Torus(40, 20), ball), test::Translated(test::PlanePatch(5, 5), { 0.0, 9.0, 0.0 })));
  const MeshTopology topology(mesh);
  const MeshComponents components = ComputeComponents(topology, LumpedMass(mesh, topology));
  ASSERT_EQ(components.Count, 3);
  EXPECT_EQ(components.EulerCharacteristic, (std::vector<std::int64_t>{ 0, 2, 1 }));
  EXPECT_EQ(components.Closed, (std::vector<bool>{ true, true, false }));
  EXPECT_NEAR(components.Area[1], 4.0 * Pi, 0.01 * 4.0 * Pi);
  EXPECT_NEAR(components.Area[2], 1.0, 1e-12);
  EXPECT_EQ(components.OfVertex[0], -1);
  Index highest = -1;
  for (const Index component : components.OfVertex)
  {
    EXPECT_LE(component, highest + 1) << "a component appears before a lower one";
    highest = std::max(highest, component);
  }
}

TEST(MeshComponents, OfAnEmptyMeshAreNone)
{
  const MeshComponents components = ComputeComponents(MeshTopology{ TriangleMesh() }, Eigen::VectorXd());
  EXPECT_EQ(components.Count, 0);
  EXPECT_TRUE(components.OfVertex.empty());
}

// --- The test meshes themselves ---------------------------------------------------------------------------------

TEST(ExampleMeshes, DecimationAndRefinementKeepTheSurface)
{
  const TriangleMesh surface = test::BumpySurface(4);
  const double area = FaceAreas(surface).sum();
  const TriangleMesh coarse = test::Decimate(surface, 600);
  EXPECT_EQ(coarse.NumberOfPoints(), 600);
  EXPECT_NEAR(FaceAreas(coarse).sum(), area, 0.02 * area);
  const TriangleMesh fine = test::RefineToSize(surface, 5000);
  EXPECT_NEAR(fine.NumberOfPoints(), 5000, 250);
  EXPECT_NEAR(FaceAreas(fine).sum(), area, 1e-12 * area);
}

TEST(ExampleMeshes, OffFilesRoundTrip)
{
  const std::string path = testing::TempDir() + "surfsynth-roundtrip.off";
  const TriangleMesh mesh = test::BumpySurface(2);
  test::WriteOff(mesh, path);
  const TriangleMesh read = test::ReadOff(path);
  EXPECT_EQ(read.Points, mesh.Points);
  EXPECT_EQ(read.Triangles, mesh.Triangles);
  EXPECT_THROW(test::ReadOff(path + ".absent"), std::runtime_error);
}
