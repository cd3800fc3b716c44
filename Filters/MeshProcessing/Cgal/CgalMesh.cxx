// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Cgal/CgalMesh.h"

#include "Core/Common/Errors.h"

#include <vector>

namespace surfsynth
{

CgalMesh ToCgalMesh(const TriangleMesh& mesh)
{
  CgalMesh result;
  result.reserve(mesh.NumberOfPoints(), 3 * (mesh.NumberOfTriangles() / 2), mesh.NumberOfTriangles());
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    result.add_vertex(ToCgalPoint(mesh.Points.row(v).transpose()));
  }
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const CgalFace face = result.add_face(CgalVertex(t(0)), CgalVertex(t(1)), CgalVertex(t(2)));
    if (face == CgalMesh::null_face())
    {
      throw InvalidInput("The mesh is not manifold or not consistently wound at triangle " + std::to_string(f) +
        "; vtkSurfaceRepairFilter repairs it.");
    }
  }
  return result;
}

TriangleMesh FromCgalMesh(const CgalMesh& mesh)
{
  std::vector<Index> place(mesh.num_vertices(), -1);
  TriangleMesh result;
  result.Points.resize(mesh.number_of_vertices(), 3);
  Index points = 0;
  for (const CgalVertex vertex : mesh.vertices())
  {
    if (!mesh.is_isolated(vertex))
    {
      place[vertex.idx()] = points;
      result.Points.row(points++) = FromCgalPoint(mesh.point(vertex)).transpose();
    }
  }
  result.Points.conservativeResize(points, 3);
  result.Triangles.resize(mesh.number_of_faces(), 3);
  Index triangles = 0;
  for (const CgalFace face : mesh.faces())
  {
    int k = 0;
    for (const CgalVertex vertex : mesh.vertices_around_face(mesh.halfedge(face)))
    {
      result.Triangles(triangles, k++) = place[vertex.idx()];
    }
    ++triangles;
  }
  return result;
}

} // namespace surfsynth
