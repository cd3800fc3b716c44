// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Remeshing/AdaptiveRemeshing.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace surfsynth
{

namespace
{
using Primitive = CGAL::AABB_face_graph_triangle_primitive<CgalMesh>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<CgalKernel, Primitive>>;

/// The surface before remeshing: finds the place of a point on it, and the target edge length there.
class SizedSurface
{
public:
  SizedSurface(const CgalMesh& mesh, const std::vector<double>& lengthOfVertex)
    : Mesh(mesh)
    , Lengths(lengthOfVertex)
    , Triangles(faces(this->Mesh).begin(), faces(this->Mesh).end(), this->Mesh)
  {
    this->Triangles.build();
  }

  std::pair<CgalPoint, double> Nearest(const CgalPoint& point) const
  {
    const auto hit = this->Triangles.closest_point_and_primitive(point);
    Eigen::Vector3d corners[3];
    double lengths[3];
    int k = 0;
    for (const CgalVertex v : this->Mesh.vertices_around_face(this->Mesh.halfedge(hit.second)))
    {
      corners[k] = FromCgalPoint(this->Mesh.point(v));
      lengths[k++] = this->Lengths[v.idx()];
    }
    const Eigen::Vector3d at = FromCgalPoint(hit.first);
    double sum = 0.0;
    double length = 0.0;
    for (k = 0; k < 3; ++k)
    {
      const double weight = (corners[(k + 1) % 3] - at).cross(corners[(k + 2) % 3] - at).norm();
      sum += weight;
      length += weight * lengths[k];
    }
    return { hit.first, sum > 0.0 ? length / sum : lengths[0] };
  }

private:
  CgalMesh Mesh;
  std::vector<double> Lengths;
  Tree Triangles;
};

/// One run of RemeshAdaptively().
class AdaptiveRemesher
{
public:
  AdaptiveRemesher(CgalMesh& mesh, const RemeshingConstraints& constraints, const std::vector<double>& lengthOfVertex)
    : Mesh(mesh)
    , IsCurve(constraints.IsCurve)
    , IsFixed(constraints.IsFixed)
    , Original(mesh, lengthOfVertex)
    , Wanted(mesh.add_property_map<CgalVertex, double>("v:wanted_length", 0.0).first)
  {
    for (const CgalVertex v : mesh.vertices())
    {
      this->Wanted[v] = lengthOfVertex[v.idx()];
    }
  }

  ~AdaptiveRemesher() { this->Mesh.remove_property_map(this->Wanted); }

  void SplitLongEdges()
  {
    // Longest first, so that the outcome depends little on the order of ids.
    std::set<std::pair<double, CgalEdge>> queue;
    const auto consider = [&](CgalEdge e) {
      const double ratio = this->LengthRatio(e);
      if (ratio > 4.0 / 3.0)
      {
        queue.insert({ -ratio, e });
      }
    };
    for (const CgalEdge e : this->Mesh.edges())
    {
      consider(e);
    }
    while (!queue.empty())
    {
      const CgalEdge e = queue.begin()->second;
      queue.erase(queue.begin());
      const CgalVertex middle = this->Split(e);
      for (const CgalHalfedge h : this->Mesh.halfedges_around_target(this->Mesh.halfedge(middle)))
      {
        consider(this->Mesh.edge(h));
      }
    }
  }

  void CollapseShortEdges()
  {
    std::vector<std::pair<double, CgalEdge>> edges;
    for (const CgalEdge e : this->Mesh.edges())
    {
      const double ratio = this->LengthRatio(e);
      if (ratio < 4.0 / 5.0)
      {
        edges.emplace_back(ratio, e);
      }
    }
    std::sort(edges.begin(), edges.end());
    for (const auto& entry : edges)
    {
      // Neighbouring collapses may have removed the edge, or made it long enough.
      if (!this->Mesh.is_removed(entry.second) && this->LengthRatio(entry.second) < 4.0 / 5.0)
      {
        const CgalHalfedge h = this->Mesh.halfedge(entry.second);
        if (!this->Collapse(h))
        {
          this->Collapse(this->Mesh.opposite(h));
        }
      }
    }
  }

  void FlipEdges()
  {
    for (const CgalEdge e : this->Mesh.edges())
    {
      if (!this->OnCurve(e))
      {
        this->FlipIfBetter(this->Mesh.halfedge(e));
      }
    }
  }

  /// Moves free vertices to the centre of the triangles around them, in units of the wanted length, along the surface.
  void Relax()
  {
    std::vector<std::pair<CgalVertex, CgalPoint>> moves;
    for (const CgalVertex v : this->Mesh.vertices())
    {
      if (!this->IsFixed[v] && !this->OnCurve(v))
      {
        moves.emplace_back(v, this->Center(v));
      }
    }
    for (const auto& move : moves)
    {
      const auto place = this->Original.Nearest(move.second);
      if (this->KeepsNormals(move.first, place.first))
      {
        this->Mesh.point(move.first) = place.first;
        this->Wanted[move.first] = place.second;
      }
    }
  }

private:
  Eigen::Vector3d At(CgalVertex v) const { return FromCgalPoint(this->Mesh.point(v)); }

  double LengthRatio(CgalEdge e) const
  {
    const CgalVertex a = this->Mesh.vertex(e, 0);
    const CgalVertex b = this->Mesh.vertex(e, 1);
    return (this->At(a) - this->At(b)).norm() / (0.5 * (this->Wanted[a] + this->Wanted[b]));
  }

  bool OnCurve(CgalEdge e) const { return this->IsCurve[e] || this->Mesh.is_border(e); }

  bool OnCurve(CgalVertex v) const
  {
    const auto around = this->Mesh.halfedges_around_target(this->Mesh.halfedge(v));
    return std::any_of(around.begin(), around.end(), [&](CgalHalfedge h) { return this->OnCurve(this->Mesh.edge(h)); });
  }

  CgalVertex Split(CgalEdge e)
  {
    const CgalHalfedge h = this->Mesh.halfedge(e);
    const bool isCurve = this->IsCurve[e];
    const CgalPoint middle = CGAL::midpoint(
      this->Mesh.point(this->Mesh.source(h)), this->Mesh.point(this->Mesh.target(h)));
    const auto place = this->Original.Nearest(middle);
    const CgalHalfedge toMiddle = CGAL::Euler::split_edge(h, this->Mesh);
    const CgalVertex v = this->Mesh.target(toMiddle);
    this->Mesh.point(v) = isCurve || this->Mesh.is_border(this->Mesh.edge(h)) ? middle : place.first;
    this->Wanted[v] = place.second;
    this->IsCurve[this->Mesh.edge(toMiddle)] = isCurve;
    if (!this->Mesh.is_border(h))
    {
      CGAL::Euler::split_face(toMiddle, this->Mesh.next(h), this->Mesh);
    }
    const CgalHalfedge back = this->Mesh.opposite(h);
    if (!this->Mesh.is_border(back))
    {
      CGAL::Euler::split_face(back, this->Mesh.next(this->Mesh.next(back)), this->Mesh);
    }
    return v;
  }

  /// Joins the source of @p h to its target, if that is allowed and makes no edge too long and no triangle turn over.
  bool Collapse(CgalHalfedge h)
  {
    const CgalVertex removed = this->Mesh.source(h);
    const CgalVertex kept = this->Mesh.target(h);
    const CgalEdge e = this->Mesh.edge(h);
    if (this->IsFixed[removed] || (this->OnCurve(removed) && !this->OnCurve(e)) ||
      !CGAL::Euler::does_satisfy_link_condition(e, this->Mesh) || this->JoinsCurves(h) || !this->MayMove(removed, kept))
    {
      return false;
    }
    const CgalPoint point = this->Mesh.point(kept);
    const double wanted = this->Wanted[kept];
    const bool isFixed = this->IsFixed[kept];
    this->IsCurve[e] = false; // CGAL collapses no constrained edge; the other edges of its curve stay marked
    const CgalVertex left = CGAL::Euler::collapse_edge(e, this->Mesh, this->IsCurve);
    this->Mesh.point(left) = point;
    this->Wanted[left] = wanted;
    this->IsFixed[left] = isFixed;
    return true;
  }

  /// True when a triangle at @p h has both other edges on curves, which the collapse would lay upon each other.
  bool JoinsCurves(CgalHalfedge h) const
  {
    const auto joins = [&](CgalHalfedge side) {
      return !this->Mesh.is_border(side) && this->OnCurve(this->Mesh.edge(this->Mesh.next(side))) &&
        this->OnCurve(this->Mesh.edge(this->Mesh.prev(side)));
    };
    return joins(h) || joins(this->Mesh.opposite(h));
  }

  bool MayMove(CgalVertex removed, CgalVertex kept) const
  {
    const Eigen::Vector3d to = this->At(kept);
    for (const CgalVertex other : this->Mesh.vertices_around_target(this->Mesh.halfedge(removed)))
    {
      const double wanted = 0.5 * (this->Wanted[other] + this->Wanted[kept]);
      if (other != kept && (this->At(other) - to).norm() > 4.0 / 3.0 * wanted)
      {
        return false;
      }
    }
    return this->KeepsNormals(removed, this->Mesh.point(kept), kept);
  }

  /// True when the triangles around @p v, except those at @p except, keep some area and their normal within 60 degrees
  /// when @p v moves to @p point.
  bool KeepsNormals(CgalVertex v, const CgalPoint& point, CgalVertex except = CgalVertex()) const
  {
    const Eigen::Vector3d to = FromCgalPoint(point);
    for (const CgalHalfedge h : this->Mesh.halfedges_around_target(this->Mesh.halfedge(v)))
    {
      const CgalVertex p = this->Mesh.target(this->Mesh.next(h));
      const CgalVertex q = this->Mesh.source(h);
      if (this->Mesh.is_border(h) || p == except || q == except)
      {
        continue;
      }
      const Eigen::Vector3d before = (this->At(p) - this->At(v)).cross(this->At(q) - this->At(v));
      const Eigen::Vector3d after = (this->At(p) - to).cross(this->At(q) - to);
      const double longest = std::max((this->At(p) - to).squaredNorm(), (this->At(q) - to).squaredNorm());
      if (before.dot(after) <= 0.5 * before.norm() * after.norm() || after.norm() < 1e-3 * longest)
      {
        return false;
      }
    }
    return true;
  }

  int Deviation(CgalVertex v, int change) const
  {
    const int wanted = this->Mesh.is_border(v) ? 4 : 6;
    return std::abs(static_cast<int>(this->Mesh.degree(v)) + change - wanted);
  }

  void FlipIfBetter(CgalHalfedge h)
  {
    const CgalHalfedge o = this->Mesh.opposite(h);
    const CgalVertex a = this->Mesh.source(h);
    const CgalVertex b = this->Mesh.target(h);
    const CgalVertex c = this->Mesh.target(this->Mesh.next(h));
    const CgalVertex d = this->Mesh.target(this->Mesh.next(o));
    const int before = this->Deviation(a, 0) + this->Deviation(b, 0) + this->Deviation(c, 0) + this->Deviation(d, 0);
    const int after = this->Deviation(a, -1) + this->Deviation(b, -1) + this->Deviation(c, 1) + this->Deviation(d, 1);
    if (after >= before || c == d || this->Mesh.halfedge(c, d) != CgalMesh::null_halfedge())
    {
      return;
    }
    // The new triangles c d b and d c a must face the way of the old ones and be no needles.
    const Eigen::Vector3d old = (this->At(b) - this->At(a)).cross(this->At(c) - this->At(a)).normalized() +
      (this->At(d) - this->At(a)).cross(this->At(b) - this->At(a)).normalized();
    const Eigen::Vector3d first = (this->At(d) - this->At(c)).cross(this->At(b) - this->At(c));
    const Eigen::Vector3d second = (this->At(c) - this->At(d)).cross(this->At(a) - this->At(d));
    const double longest = (this->At(c) - this->At(d)).squaredNorm();
    const auto faces = [&](const Eigen::Vector3d& normal) {
      return normal.norm() > 0.05 * longest && normal.dot(old) > 0.5 * normal.norm() * old.norm();
    };
    if (faces(first) && faces(second))
    {
      CGAL::Euler::flip_edge(h, this->Mesh);
    }
  }

  CgalPoint Center(CgalVertex v) const
  {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (const CgalFace f : this->Mesh.faces_around_target(this->Mesh.halfedge(v)))
    {
      Eigen::Vector3d corners[3];
      double wanted = 0.0;
      int k = 0;
      for (const CgalVertex corner : this->Mesh.vertices_around_face(this->Mesh.halfedge(f)))
      {
        corners[k++] = this->At(corner);
        wanted += this->Wanted[corner] / 3.0;
      }
      const Eigen::Vector3d area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      const double weight = area.norm() / (wanted * wanted);
      sum += weight * (corners[0] + corners[1] + corners[2]) / 3.0;
      weights += weight;
      normal += area;
    }
    const Eigen::Vector3d at = this->At(v);
    if (!(weights > 0.0) || !(normal.norm() > 0.0))
    {
      return this->Mesh.point(v);
    }
    normal.normalize();
    const Eigen::Vector3d move = sum / weights - at;
    return ToCgalPoint(at + move - normal.dot(move) * normal);
  }

  CgalMesh& Mesh;
  CgalMesh::Property_map<CgalEdge, bool> IsCurve;
  CgalMesh::Property_map<CgalVertex, bool> IsFixed;
  SizedSurface Original;
  CgalMesh::Property_map<CgalVertex, double> Wanted;
};
} // namespace

void RemeshAdaptively(CgalMesh& mesh, const RemeshingConstraints& constraints,
  const std::vector<double>& lengthOfVertex, int iterations, int relaxationSteps, const std::atomic<bool>* stop)
{
  AdaptiveRemesher remesher(mesh, constraints, lengthOfVertex);
  for (int round = 0; round < iterations && !(stop && stop->load()); ++round)
  {
    remesher.SplitLongEdges();
    remesher.CollapseShortEdges();
    remesher.FlipEdges();
    for (int step = 0; step < relaxationSteps; ++step)
    {
      remesher.Relax();
    }
  }
}

} // namespace surfsynth
