// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/FlatTriangles.h"

#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <vector>

namespace surfsynth
{

namespace
{
struct Corner
{
  CgalHalfedge Longest; ///< the halfedge of the longest side
  CgalHalfedge Shortest;
  double Ratio = 0.0; ///< of the squared shortest to the squared longest side
  bool IsFlat = false;
};

/// The sides of a triangle, and the test of the mesh check for a degenerate one.
Corner Look(const CgalMesh& mesh, CgalFace f)
{
  Corner corner;
  double longest = -1.0;
  double shortest = std::numeric_limits<double>::infinity();
  for (const CgalHalfedge h : mesh.halfedges_around_face(mesh.halfedge(f)))
  {
    const double length = CGAL::squared_distance(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)));
    if (length > longest)
    {
      longest = length;
      corner.Longest = h;
    }
    if (length < shortest)
    {
      shortest = length;
      corner.Shortest = h;
    }
  }
  const CgalHalfedge h = corner.Longest;
  const Eigen::Vector3d a = FromCgalPoint(mesh.point(mesh.source(h)));
  const Eigen::Vector3d b = FromCgalPoint(mesh.point(mesh.target(h)));
  const Eigen::Vector3d c = FromCgalPoint(mesh.point(mesh.target(mesh.next(h))));
  const double doubleArea = (b - a).cross(c - a).norm();
  corner.Ratio = longest > 0.0 ? shortest / longest : 0.0;
  corner.IsFlat = !(doubleArea > 4e-12 * longest && doubleArea > 1e-290); // twice the bound of the check
  return corner;
}

/// Takes one flat triangle away. @return false when nothing is possible
bool RemoveFlat(CgalMesh& mesh, CgalFace f, const Corner& corner)
{
  if (corner.Ratio < 1e-10 && CGAL::Euler::does_satisfy_link_condition(mesh.edge(corner.Shortest), mesh))
  {
    CGAL::Euler::collapse_edge(mesh.edge(corner.Shortest), mesh);
    return true;
  }
  const CgalHalfedge opposite = mesh.opposite(corner.Longest);
  if (mesh.is_border(opposite))
  {
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
    return true;
  }
  const CgalVertex apex = mesh.target(mesh.next(corner.Longest));
  const CgalVertex other = mesh.target(mesh.next(opposite));
  if (apex != other && mesh.halfedge(apex, other) == CgalMesh::null_halfedge())
  {
    CGAL::Euler::flip_edge(corner.Longest, mesh);
    return true;
  }
  if (CGAL::Euler::does_satisfy_link_condition(mesh.edge(corner.Shortest), mesh))
  {
    CGAL::Euler::collapse_edge(mesh.edge(corner.Shortest), mesh);
    return true;
  }
  return false;
}
} // namespace

bool IsFlatTriangle(const CgalMesh& mesh, CgalFace f) { return Look(mesh, f).IsFlat; }

std::int64_t CountFlatTriangles(const CgalMesh& mesh)
{
  const auto faces = mesh.faces();
  return std::count_if(faces.begin(), faces.end(), [&](CgalFace f) { return Look(mesh, f).IsFlat; });
}

void RemoveFlatTriangles(CgalMesh& mesh)
{
  bool found = true;
  for (int round = 0; round < 20 && found; ++round)
  {
    found = false;
    const std::vector<CgalFace> faces(mesh.faces().begin(), mesh.faces().end());
    for (const CgalFace f : faces)
    {
      const Corner corner = mesh.is_removed(f) ? Corner() : Look(mesh, f);
      found = (corner.IsFlat && RemoveFlat(mesh, f, corner)) || found;
    }
  }
}

} // namespace surfsynth
