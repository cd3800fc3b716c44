// SPDX-License-Identifier: BSD-3-Clause
//
// ToCgalMesh() and FromCgalMesh(): the same mesh there and back.
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "MeshProcessing/Cgal/CgalMesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

namespace
{
TriangleMesh WithTriangles(Index points, std::initializer_list<std::array<Index, 3>> triangles)
{
  TriangleMesh mesh;
  mesh.Points.resize(points, 3);
  for (Index v = 0; v < points; ++v)
  {
    mesh.Points.row(v) << v, v * v, v * v * v; // no four in a plane
  }
  mesh.Triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  Eigen::Index f = 0;
  for (const std::array<Index, 3>& triangle : triangles)
  {
    mesh.Triangles.row(f++) << triangle[0], triangle[1], triangle[2];
  }
  return mesh;
}
} // namespace

TEST(CgalMesh, RoundTripKeepsPointsAndTriangles)
{
  for (const TriangleMesh& mesh : { Icosphere(2), Torus(12, 8), PlanePatch(5, 4), OpenCylinder(9, 3),
         Join(Tetrahedron(), Translated(Icosphere(1), { 5, 0, 0 })) })
  {
    const TriangleMesh back = FromCgalMesh(ToCgalMesh(mesh));
    EXPECT_EQ(back.Points, mesh.Points);
    EXPECT_TRUE(SameTriangles(back.Triangles, mesh.Triangles));
  }
}

TEST(CgalMesh, IndicesAreThoseOfPointsAndTriangles)
{
  const TriangleMesh mesh = Icosphere(1);
  const CgalMesh converted = ToCgalMesh(mesh);
  ASSERT_EQ(converted.number_of_vertices(), 42U);
  ASSERT_EQ(converted.number_of_faces(), 80U);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_EQ(FromCgalPoint(converted.point(CgalVertex(v))), Eigen::Vector3d(mesh.Points.row(v).transpose()));
  }
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (const CgalVertex v : converted.vertices_around_face(converted.halfedge(CgalFace(f))))
    {
      EXPECT_TRUE((mesh.Triangles.row(f).array() == static_cast<Index>(v.idx())).any()) << f;
    }
  }
}

TEST(CgalMesh, BoundaryEdgesAreTheBorder)
{
  const CgalMesh mesh = ToCgalMesh(OpenCylinder(9, 3));
  const auto halfedges = mesh.halfedges();
  EXPECT_EQ(std::count_if(halfedges.begin(), halfedges.end(), [&](CgalHalfedge h) { return mesh.is_border(h); }), 18);
}

TEST(CgalMesh, UnusedPointsAndRemovedFacesAreLeftOut)
{
  const TriangleMesh stray = WithUnreferencedPoints(Icosphere(1));
  ASSERT_GT(stray.NumberOfPoints(), 42);
  CgalMesh mesh = ToCgalMesh(stray);
  EXPECT_EQ(static_cast<Index>(mesh.number_of_vertices()), stray.NumberOfPoints());
  const TriangleMesh used = FromCgalMesh(mesh);
  EXPECT_EQ(used.Points, Icosphere(1).Points);
  EXPECT_TRUE(SameTriangles(used.Triangles, Icosphere(1).Triangles));

  mesh.remove_face(CgalFace(7));
  EXPECT_EQ(FromCgalMesh(mesh).NumberOfTriangles(), 79);
}

TEST(CgalMesh, NonManifoldEdgesAndOppositeWindingAreInvalid)
{
  const auto convert = [](const TriangleMesh& mesh) { return [mesh] { ToCgalMesh(mesh); }; };
  EXPECT_THAT(convert(WithTriangles(5, { { 0, 1, 2 }, { 1, 0, 3 }, { 0, 1, 4 } })),
    ThrowsMessage<InvalidInput>(
      "The mesh is not manifold or not consistently wound at triangle 2; vtkSurfaceRepairFilter repairs it."));
  EXPECT_THAT(convert(WithTriangles(4, { { 0, 1, 2 }, { 0, 1, 3 } })),
    ThrowsMessage<InvalidInput>(HasSubstr("not consistently wound at triangle 1;")));
  EXPECT_THAT(convert(MoebiusStrip(12, 2)), ThrowsMessage<InvalidInput>(HasSubstr("not consistently wound")));
}

TEST(CgalMesh, EmptyMeshStaysEmpty)
{
  const TriangleMesh back = FromCgalMesh(ToCgalMesh(TriangleMesh()));
  EXPECT_EQ(back.NumberOfPoints(), 0);
  EXPECT_EQ(back.NumberOfTriangles(), 0);
}
