// SPDX-License-Identifier: BSD-3-Clause
// Distances along edges: the shortest of all paths.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/EdgeDistances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
/// Paths lengthened edge by edge until none gets shorter.
Eigen::VectorXd Defined(const TriangleMesh& mesh, const std::vector<Index>& sources)
{
  Eigen::VectorXd distances = Eigen::VectorXd::Constant(mesh.NumberOfPoints(), std::numeric_limits<double>::infinity());
  for (const Index source : sources)
  {
    distances[source] = 0.0;
  }
  for (bool changes = true; changes;)
  {
    changes = false;
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      for (int k = 0; k < 6; ++k)
      {
        const Index a = mesh.Triangles(f, k % 3);
        const Index b = mesh.Triangles(f, (k % 3 + 1 + k / 3) % 3);
        const double through = distances[a] + (mesh.Points.row(a) - mesh.Points.row(b)).norm();
        if (through < distances[b] * (1.0 - 1e-14))
        {
          distances[b] = through;
          changes = true;
        }
      }
    }
  }
  return distances;
}

/// A rhombus of @p n by @p n pairs of triangles whose edges are 1 long.
TriangleMesh EquilateralTriangles(Index n)
{
  TriangleMesh mesh;
  mesh.Points.resize((n + 1) * (n + 1), 3);
  mesh.Triangles.resize(2 * n * n, 3);
  for (Index row = 0; row <= n; ++row)
  {
    for (Index column = 0; column <= n; ++column)
    {
      const Index v = row * (n + 1) + column;
      mesh.Points.row(v) << column + 0.5 * row, std::sqrt(0.75) * row, 0.0;
      if (row < n && column < n)
      {
        const Index f = 2 * (row * n + column);
        mesh.Triangles.row(f) << v, v + 1, v + n + 1;
        mesh.Triangles.row(f + 1) << v + 1, v + n + 2, v + n + 1;
      }
    }
  }
  return mesh;
}
} // namespace

TEST(EdgeDistances, AreThoseOfTheShortestPaths)
{
  for (const TriangleMesh& mesh : { IrregularSphere(2), PlanePatch(9, 7, 2.0, 1.0, 0.2), OpenCylinder(12, 5) })
  {
    const std::vector<Index> sources = { 3, 17, 20 };
    const Eigen::VectorXd found = EdgeDistances(mesh, MeshTopology(mesh), sources);
    EXPECT_LE((found - Defined(mesh, sources)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(EdgeDistances, OnEquilateralTrianglesAreATightBoundOnDistances)
{
  const TriangleMesh mesh = EquilateralTriangles(20);
  const MeshTopology topology(mesh);
  const Index middle = 10 * 21 + 10;
  const Eigen::VectorXd found = EdgeDistances(mesh, topology, { middle });
  double largestRatio = 0.0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double straight = (mesh.Points.row(v) - mesh.Points.row(middle)).norm();
    EXPECT_GE(found[v], straight - 1e-12);
    EXPECT_LE(found[v], 2.0 / std::sqrt(3.0) * straight + 1e-12);
    largestRatio = v == middle ? largestRatio : std::max(largestRatio, found[v] / straight);
  }
  EXPECT_NEAR(largestRatio, 2.0 / std::sqrt(3.0), 1e-12) << "half way between two directions of edges";
}

TEST(EdgeDistances, AreInfiniteWhereNoPathLeads)
{
  const TriangleMesh two = Join(Tetrahedron(), Translated(Tetrahedron(), { 5.0, 0.0, 0.0 }));
  const Eigen::VectorXd found = EdgeDistances(two, MeshTopology(two), { 1 });
  EXPECT_EQ(found[1], 0.0);
  EXPECT_TRUE(found.head(4).allFinite());
  EXPECT_TRUE(std::isinf(found.tail(4).minCoeff()));
  EXPECT_TRUE(std::isinf(EdgeDistances(two, MeshTopology(two), {}).minCoeff()));
}

TEST(EdgeDistances, RefuseSourcesThatAreNoVertices)
{
  const TriangleMesh mesh = Tetrahedron();
  EXPECT_THROW(EdgeDistances(mesh, MeshTopology(mesh), { 4 }), InvalidInput);
  EXPECT_THROW(EdgeDistances(mesh, MeshTopology(mesh), { -1 }), InvalidInput);
}
