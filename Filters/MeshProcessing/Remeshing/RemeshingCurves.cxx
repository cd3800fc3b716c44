// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Remeshing/RemeshingCurves.h"

#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"

#include "Core/Common/Errors.h"

#include <CGAL/AABB_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace surfsynth
{

namespace
{
/// A curve turns sharply where its direction changes by more than 45 degrees.
constexpr double SharpTurn = 0.70710678118654752;

/// Length of a crease that is kept, in edges of the wanted length.
constexpr double ShortestCrease = 5.0;
} // namespace

CurvedMesh::CurvedMesh(const TriangleMesh& mesh, const RemeshingOptions& options)
  : Mesh(ToCgalMesh(mesh))
{
  for (const CgalVertex v : this->Mesh.vertices())
  {
    if (this->Mesh.is_isolated(v))
    {
      this->Mesh.remove_vertex(v); // the steps of remeshing take a triangle at every vertex for granted
    }
  }
  this->Constraints.IsCurve = this->Mesh.add_property_map<CgalEdge, bool>("e:curve", false).first;
  this->Constraints.IsFixed = this->Mesh.add_property_map<CgalVertex, bool>("v:fixed", false).first;
  if (!options.PointClasses.empty())
  {
    this->MarkSeams(mesh, options.PointClasses);
  }
  if (options.FeatureAngle < 180.0)
  {
    this->MarkCreases(options);
  }
  this->FixCorners(options.KeepBoundaryPoints);
  this->RequireThickness();
}

/// Two triangles on the same points enclose nothing, and CGAL's steps fail on them.
void CurvedMesh::RequireThickness() const
{
  for (const CgalEdge e : this->Mesh.edges())
  {
    const CgalHalfedge h = this->Mesh.halfedge(e);
    const CgalHalfedge o = this->Mesh.opposite(h);
    if (!this->Mesh.is_border(e) && this->Mesh.target(this->Mesh.next(h)) == this->Mesh.target(this->Mesh.next(o)))
    {
      throw InvalidInput("Triangles " + std::to_string(this->Mesh.face(h).idx()) + " and " +
        std::to_string(this->Mesh.face(o).idx()) +
        " have the same three points; a surface with one triangle on any three points is needed, and "
        "vtkSurfaceRepairFilter removes the others.");
    }
  }
}

/// Sews boundaries of equal coordinates together. An edge is a seam where the points on its two sides differ in class.
void CurvedMesh::MarkSeams(const TriangleMesh& mesh, const std::vector<Index>& classes)
{
  CGAL::Polygon_mesh_processing::stitch_borders(this->Mesh);
  // CGAL's triangle f still is the input's, but its corners may have become other vertices.
  auto classAt = this->Mesh.add_property_map<CgalHalfedge, Index>("h:class", -1).first;
  for (const CgalFace face : this->Mesh.faces())
  {
    const auto f = static_cast<Index>(face.idx());
    for (const CgalHalfedge h : this->Mesh.halfedges_around_face(this->Mesh.halfedge(face)))
    {
      int corner = 0;
      for (int k = 0; k < 3; ++k)
      {
        const bool same = FromCgalPoint(this->Mesh.point(this->Mesh.target(h))) ==
          Eigen::Vector3d(mesh.Points.row(mesh.Triangles(f, k)).transpose());
        corner = same ? k : corner;
      }
      classAt[h] = classes[mesh.Triangles(f, corner)];
    }
  }
  for (const CgalEdge e : this->Mesh.edges())
  {
    const CgalHalfedge h = this->Mesh.halfedge(e);
    const CgalHalfedge o = this->Mesh.opposite(h);
    this->Constraints.IsCurve[e] = !this->Mesh.is_border(e) &&
      (classAt[h] != classAt[this->Mesh.prev(o)] || classAt[this->Mesh.prev(h)] != classAt[o]);
  }
  this->Mesh.remove_property_map(classAt);
}

/// Marks the creases, except those that are shorter in all than a few of the wanted edges: these are noise.
void CurvedMesh::MarkCreases(const RemeshingOptions& options)
{
  auto isSharp = this->Mesh.add_property_map<CgalEdge, bool>("e:sharp", false).first;
  CGAL::Polygon_mesh_processing::detect_sharp_edges(this->Mesh, options.FeatureAngle, isSharp);
  const auto lengthInEdges = [&](CgalEdge e) {
    const CgalVertex a = this->Mesh.vertex(e, 0);
    const CgalVertex b = this->Mesh.vertex(e, 1);
    const double wanted = options.PointEdgeLengths.empty()
      ? options.EdgeLength
      : 0.5 * (options.PointEdgeLengths[a.idx()] + options.PointEdgeLengths[b.idx()]);
    return std::sqrt(CGAL::squared_distance(this->Mesh.point(a), this->Mesh.point(b))) / wanted;
  };
  std::vector<bool> reached(this->Mesh.num_edges(), false);
  for (const CgalEdge first : this->Mesh.edges())
  {
    if (!isSharp[first] || reached[first.idx()])
    {
      continue;
    }
    std::vector<CgalEdge> crease{ first };
    reached[first.idx()] = true;
    double length = 0.0;
    for (std::size_t k = 0; k < crease.size(); ++k) // grows while it is read
    {
      length += lengthInEdges(crease[k]);
      for (const CgalVertex v : { this->Mesh.vertex(crease[k], 0), this->Mesh.vertex(crease[k], 1) })
      {
        for (const CgalHalfedge h : this->Mesh.halfedges_around_target(this->Mesh.halfedge(v)))
        {
          const CgalEdge next = this->Mesh.edge(h);
          if (isSharp[next] && !reached[next.idx()])
          {
            reached[next.idx()] = true;
            crease.push_back(next);
          }
        }
      }
    }
    for (const CgalEdge e : crease)
    {
      this->Constraints.IsCurve[e] = this->Constraints.IsCurve[e] || length >= ShortestCrease;
    }
  }
  this->Mesh.remove_property_map(isSharp);
}

/// Vertices where curves end, meet or turn sharply stay where they are, and corners of triangles by themselves: an obtuse one
/// would be put onto the opposite side.
void CurvedMesh::FixCorners(bool fixBoundary)
{
  for (const CgalVertex v : this->Mesh.vertices())
  {
    std::vector<CgalHalfedge> curve;
    bool isBoundary = false;
    bool isAlone = true;
    for (const CgalHalfedge h : this->Mesh.halfedges_around_target(this->Mesh.halfedge(v)))
    {
      const bool border = this->Mesh.is_border(this->Mesh.edge(h));
      isBoundary = isBoundary || border;
      if (border || this->Constraints.IsCurve[this->Mesh.edge(h)])
      {
        curve.push_back(h);
      }
      if (!this->Mesh.is_border(h))
      {
        const auto sides = this->Mesh.halfedges_around_face(h);
        isAlone = isAlone && std::all_of(sides.begin(), sides.end(), [&](CgalHalfedge side) {
          return this->Mesh.is_border(this->Mesh.edge(side));
        });
      }
    }
    this->Constraints.IsFixed[v] = ((fixBoundary || isAlone) && isBoundary) ||
      (!curve.empty() && (curve.size() != 2 || this->TurnsSharply(v, curve)));
  }
}

bool CurvedMesh::TurnsSharply(CgalVertex v, const std::vector<CgalHalfedge>& curve) const
{
  const Eigen::Vector3d at = FromCgalPoint(this->Mesh.point(v));
  const Eigen::Vector3d in = at - FromCgalPoint(this->Mesh.point(this->Mesh.source(curve[0])));
  const Eigen::Vector3d out = FromCgalPoint(this->Mesh.point(this->Mesh.source(curve[1]))) - at;
  return in.dot(out) < SharpTurn * in.norm() * out.norm();
}

class OriginalCurves::Internals
{
public:
  using Segment = CgalKernel::Segment_3;
  using Segments = std::vector<Segment>;
  using Primitive = CGAL::AABB_segment_primitive<CgalKernel, Segments::const_iterator>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<CgalKernel, Primitive>>;

  /// Triangles at a segment: those beside it, and those around either end.
  struct Surroundings
  {
    std::vector<Index> Inside;
    std::vector<Index> Source;
    std::vector<Index> Target;
  };

  explicit Internals(const CurvedMesh& sewn)
  {
    const CgalMesh& mesh = sewn.Mesh;
    const auto trianglesAround = [&](CgalVertex v) {
      std::vector<Index> triangles;
      for (const CgalFace f : mesh.faces_around_target(mesh.halfedge(v)))
      {
        if (f != CgalMesh::null_face())
        {
          triangles.push_back(static_cast<Index>(f.idx()));
        }
      }
      return triangles;
    };
    for (const CgalEdge e : mesh.edges())
    {
      if (!mesh.is_border(e) && !sewn.Constraints.IsCurve[e])
      {
        continue;
      }
      const CgalHalfedge h = mesh.halfedge(e);
      Surroundings around{ {}, trianglesAround(mesh.source(h)), trianglesAround(mesh.target(h)) };
      for (const CgalHalfedge side : { h, mesh.opposite(h) })
      {
        if (!mesh.is_border(side))
        {
          around.Inside.push_back(static_cast<Index>(mesh.face(side).idx()));
        }
      }
      this->Curve.emplace_back(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)));
      this->Around.push_back(std::move(around));
    }
    this->Nearest.rebuild(this->Curve.cbegin(), this->Curve.cend());
    this->Nearest.build();
  }

  Segments Curve;
  std::vector<Surroundings> Around;
  Tree Nearest;
};

OriginalCurves::OriginalCurves(const CurvedMesh& sewn)
  : Impl(std::make_unique<Internals>(sewn))
{}

OriginalCurves::~OriginalCurves() = default;

OriginalCurves::Foot OriginalCurves::Nearest(const Eigen::Vector3d& point) const
{
  const auto hit = this->Impl->Nearest.closest_point_and_primitive(ToCgalPoint(point));
  const auto segment = static_cast<std::size_t>(std::distance(this->Impl->Curve.cbegin(), hit.second));
  const Internals::Surroundings& around = this->Impl->Around[segment];
  const CgalPoint source = this->Impl->Curve[segment].source();
  const CgalPoint target = this->Impl->Curve[segment].target();
  const double tolerance = 1e-18 * CGAL::squared_distance(source, target);
  if (CGAL::squared_distance(hit.first, source) <= tolerance)
  {
    return { FromCgalPoint(source), around.Source };
  }
  if (CGAL::squared_distance(hit.first, target) <= tolerance)
  {
    return { FromCgalPoint(target), around.Target };
  }
  return { FromCgalPoint(hit.first), around.Inside };
}

} // namespace surfsynth
