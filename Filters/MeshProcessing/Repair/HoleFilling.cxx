// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/HoleFilling.h"

#include "MeshProcessing/Repair/FlatTriangles.h"
#include "MeshProcessing/Repair/SelfIntersections.h"

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

  /// True when the piece of @p start lies in a plane: closing its outline would double it.
  bool IsFlat(CgalHalfedge start) const
  {
    const std::size_t piece = this->Component[this->Mesh.face(this->Mesh.opposite(start)).idx()];
    const Eigen::Vector3d origin = FromCgalPoint(this->Mesh.point(this->Mesh.target(start)));
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> offsets;
    for (const CgalFace f : this->Mesh.faces())
    {
      if (f.idx() < this->Component.size() && this->Component[f.idx()] == piece)
      {
        Eigen::Vector3d corners[3];
        std::size_t k = 0;
        for (const CgalVertex v : this->Mesh.vertices_around_face(this->Mesh.halfedge(f)))
        {
          corners[k++] = FromCgalPoint(this->Mesh.point(v)) - origin;
        }
        normal += (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        offsets.insert(offsets.end(), corners, corners + 3);
      }
    }
    normal.normalize();
    const double tolerance = 1e-9 * this->Boxes[piece].diagonal().norm();
    return std::all_of(offsets.begin(), offsets.end(),
      [&](const Eigen::Vector3d& offset) { return std::abs(offset.dot(normal)) <= tolerance; });
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

/// Shapes of the triangles that close a hole, in the order in which they are tried.
enum class Filling
{
  Faired,  ///< with points inside that continue the curvature
  Refined, ///< with points inside
  Plain,   ///< without points inside
  None     ///< left open
};

std::vector<CgalFace> CloseHole(CgalMesh& mesh, const std::vector<CgalHalfedge>& boundary, Filling filling)
{
  namespace PMP = CGAL::Polygon_mesh_processing;
  std::vector<CgalFace> faces;
  std::vector<CgalVertex> vertices;
  const CgalHalfedge start = boundary.front();
  if (boundary.size() > VeryLongBoundary)
  {
    return CloseByFan(mesh, boundary);
  }
  if (boundary.size() > LongBoundary)
  {
    PMP::triangulate_hole(mesh, start, std::back_inserter(faces), CGAL::parameters::do_not_use_cubic_algorithm(true));
  }
  else if (filling == Filling::Faired)
  {
    PMP::triangulate_refine_and_fair_hole(mesh, start, std::back_inserter(faces), std::back_inserter(vertices));
  }
  else if (filling == Filling::Refined)
  {
    PMP::triangulate_and_refine_hole(mesh, start, std::back_inserter(faces), std::back_inserter(vertices));
  }
  else
  {
    PMP::triangulate_hole(mesh, start, std::back_inserter(faces));
  }
  return faces.empty() ? CloseByFan(mesh, boundary) : faces;
}

/// A boundary, and the triangles that close it.
struct Hole
{
  CgalHalfedge Start;
  std::size_t Length = 0; ///< number of edges
  std::vector<CgalFace> Patch;
  Filling Shape = Filling::Faired;
};

/// Closes holes, and replaces the patches that do not meet the requirements.
class HoleFiller
{
public:
  HoleFiller(CgalMesh& mesh, const FillingRequirements& requirements, const std::atomic<bool>* stop)
    : Mesh(mesh)
    , Requirements(requirements)
    , Stop(stop)
  {}

  void Close(Hole& hole)
  {
    if (this->Stop && this->Stop->load())
    {
      throw Cancelled("Stopped on request.");
    }
    hole.Patch = CloseHole(this->Mesh, BoundaryOf(this->Mesh, hole.Start), hole.Shape);
  }

  void ReplaceUnsuitable(std::vector<Hole>& holes)
  {
    constexpr int Rounds = 4; // a patch for each shape, and one more for those that the new ones of others meet
    for (int round = 0; round < Rounds && this->RequiresMore(); ++round)
    {
      const std::vector<bool> isUnsuitable = this->FindUnsuitable(holes);
      if (std::none_of(isUnsuitable.begin(), isUnsuitable.end(), [](bool is) { return is; }))
      {
        return;
      }
      for (std::size_t k = 0; k < holes.size(); ++k)
      {
        if (isUnsuitable[k])
        {
          const bool isLast = round + 1 == Rounds || holes[k].Length > LongBoundary;
          this->Replace(holes[k], isLast ? Filling::None : static_cast<Filling>(static_cast<int>(holes[k].Shape) + 1));
        }
      }
    }
  }

private:
  bool RequiresMore() const { return this->Requirements.NoFlatTriangles || this->Requirements.NoIntersections; }

  void Replace(Hole& hole, Filling shape)
  {
    for (const CgalFace f : hole.Patch)
    {
      CGAL::Euler::remove_face(this->Mesh.halfedge(f), this->Mesh);
    }
    hole.Patch.clear();
    hole.Shape = shape;
    if (shape != Filling::None)
    {
      this->Close(hole);
    }
  }

  std::vector<bool> FindUnsuitable(const std::vector<Hole>& holes) const
  {
    std::vector<bool> isUnsuitable(holes.size(), false);
    std::vector<std::size_t> holeOf(this->Mesh.num_faces(), holes.size());
    for (std::size_t k = 0; k < holes.size(); ++k)
    {
      for (const CgalFace f : holes[k].Patch)
      {
        holeOf[f.idx()] = k;
        isUnsuitable[k] = isUnsuitable[k] || (this->Requirements.NoFlatTriangles && IsFlatTriangle(this->Mesh, f));
      }
    }
    if (this->Requirements.NoIntersections)
    {
      const std::vector<CgalFace> faces(this->Mesh.faces().begin(), this->Mesh.faces().end());
      for (const Index f : FindIntersectingTriangles(FromCgalMesh(this->Mesh), this->Stop))
      {
        const std::size_t hole = holeOf[faces[static_cast<std::size_t>(f)].idx()];
        if (hole < holes.size())
        {
          isUnsuitable[hole] = true;
        }
      }
    }
    return isUnsuitable;
  }

  CgalMesh& Mesh;
  const FillingRequirements& Requirements;
  const std::atomic<bool>* Stop;
};

/// The boundaries to close; counts the others.
std::vector<Hole> FindHoles(const CgalMesh& mesh, double largest, FilledHoles& holes)
{
  std::vector<CgalHalfedge> starts;
  CGAL::Polygon_mesh_processing::extract_boundary_cycles(mesh, std::back_inserter(starts));
  std::vector<Hole> found;
  if (starts.empty())
  {
    return found;
  }
  const Outlines outlines(mesh);
  for (const CgalHalfedge start : starts)
  {
    const std::vector<CgalHalfedge> boundary = BoundaryOf(mesh, start);
    const Eigen::AlignedBox3d box = Box(mesh, boundary);
    if (box.diagonal().norm() > largest || (std::isfinite(largest) && outlines.Holds(start, box)))
    {
      ++holes.LeftOpen;
    }
    else if (outlines.Holds(start, box) && outlines.IsFlat(start))
    {
      ++holes.FlatOutlines;
    }
    else
    {
      found.push_back({ start, boundary.size(), {}, Filling::Faired });
    }
  }
  return found;
}
} // namespace

FilledHoles FillHoles(CgalMesh& mesh, double largest, CgalMesh::Property_map<CgalFace, bool>& isFilling,
  const std::atomic<bool>* stop, const FillingRequirements& requirements)
{
  FilledHoles result;
  std::vector<Hole> holes = FindHoles(mesh, largest, result);
  HoleFiller filler(mesh, requirements, stop);
  for (Hole& hole : holes)
  {
    filler.Close(hole);
  }
  filler.ReplaceUnsuitable(holes);
  for (const Hole& hole : holes)
  {
    ++(hole.Patch.empty() ? result.Unsuitable : result.Closed);
    for (const CgalFace f : hole.Patch)
    {
      isFilling[f] = true;
    }
  }
  return result;
}

} // namespace surfsynth
