// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/HoleFilling.h"

#include "Core/Common/Errors.h"

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <boost/property_map/function_property_map.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

namespace surfsynth
{

namespace
{
/// Limits of the number of edges: boundaries of more edges are closed without new points inside, and even longer ones
/// by triangles from their centre. The cost increases with the square of the number of edges, and more.
constexpr std::size_t LongBoundary = 500;
constexpr std::size_t VeryLongBoundary = 5000;

/// The halfedges of the boundary of @p start.
std::vector<CgalHalfedge> BoundaryOf(const CgalMesh& mesh, CgalHalfedge start)
{
  const auto around = mesh.halfedges_around_face(start);
  return { around.begin(), around.end() };
}

/// The bounding box of the targets of @p halfedges.
template <typename Halfedges>
Eigen::AlignedBox3d Box(const CgalMesh& mesh, const Halfedges& halfedges)
{
  Eigen::AlignedBox3d box;
  for (const CgalHalfedge h : halfedges)
  {
    box.extend(FromCgalPoint(mesh.point(mesh.target(h))));
  }
  return box;
}

/// Distinguishes the outline of a piece of surface, which lies within the bounding box of the boundary, from a hole: a
/// closed outline would be two layers of triangles without a volume.
class Outlines
{
public:
  explicit Outlines(const CgalMesh& mesh)
    : Mesh(mesh)
    , Component(mesh.number_of_faces() + mesh.number_of_removed_faces())
  {
    std::vector<std::size_t>& component = this->Component;
    this->Boxes.resize(CGAL::Polygon_mesh_processing::connected_components(mesh,
      boost::make_function_property_map<CgalFace, std::size_t&>(
        [&component](CgalFace f) -> std::size_t& { return component[f.idx()]; })));
    for (const CgalFace f : mesh.faces())
    {
      this->Boxes[component[f.idx()]].extend(Box(mesh, mesh.halfedges_around_face(mesh.halfedge(f))));
    }
  }

  bool Holds(CgalHalfedge start, const Eigen::AlignedBox3d& boundary) const
  {
    const CgalFace face = this->Mesh.face(this->Mesh.opposite(start));
    const Eigen::AlignedBox3d& piece = this->Boxes[this->Component[face.idx()]];
    return piece.diagonal().norm() <= (1.0 + 1e-9) * boundary.diagonal().norm();
  }

private:
  const CgalMesh& Mesh;
  std::vector<std::size_t> Component; ///< by face
  std::vector<Eigen::AlignedBox3d> Boxes;
};

/// Closes a boundary by triangles from its centre, which always works. @return the triangles
std::vector<CgalFace> CloseByFan(CgalMesh& mesh, const std::vector<CgalHalfedge>& boundary)
{
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const CgalHalfedge h : boundary)
  {
    center += FromCgalPoint(mesh.point(mesh.target(h))) / static_cast<double>(boundary.size());
  }
  CGAL::Euler::fill_hole(boundary.front(), mesh);
  const CgalHalfedge toCenter = CGAL::Euler::add_center_vertex(boundary.front(), mesh);
  mesh.point(mesh.target(toCenter)) = ToCgalPoint(center);
  std::vector<CgalFace> faces;
  for (const CgalFace f : mesh.faces_around_target(toCenter))
  {
    faces.push_back(f);
  }
  return faces;
}

std::vector<CgalFace> CloseHole(CgalMesh& mesh, const std::vector<CgalHalfedge>& boundary)
{
  namespace PMP = CGAL::Polygon_mesh_processing;
  std::vector<CgalFace> faces;
  std::vector<CgalVertex> vertices;
  if (boundary.size() > VeryLongBoundary)
  {
    return CloseByFan(mesh, boundary);
  }
  if (boundary.size() > LongBoundary)
  {
    PMP::triangulate_hole(
      mesh, boundary.front(), std::back_inserter(faces), CGAL::parameters::do_not_use_cubic_algorithm(true));
  }
  else
  {
    PMP::triangulate_refine_and_fair_hole(
      mesh, boundary.front(), std::back_inserter(faces), std::back_inserter(vertices));
  }
  return faces.empty() ? CloseByFan(mesh, boundary) : faces;
}

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

FilledHoles FillHoles(
  CgalMesh& mesh, double largest, CgalMesh::Property_map<CgalFace, bool>& isFilling, const std::atomic<bool>* stop)
{
  std::vector<CgalHalfedge> starts;
  CGAL::Polygon_mesh_processing::extract_boundary_cycles(mesh, std::back_inserter(starts));
  const Outlines outlines(mesh);
  FilledHoles holes;
  for (const CgalHalfedge start : starts)
  {
    if (stop && stop->load())
    {
      throw Cancelled("Stopped on request.");
    }
    const std::vector<CgalHalfedge> boundary = BoundaryOf(mesh, start);
    const Eigen::AlignedBox3d box = Box(mesh, boundary);
    if (box.diagonal().norm() > largest || (std::isfinite(largest) && outlines.Holds(start, box)))
    {
      ++holes.LeftOpen;
      continue;
    }
    for (const CgalFace f : CloseHole(mesh, boundary))
    {
      isFilling[f] = true;
    }
    ++holes.Closed;
  }
  return holes;
}

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
