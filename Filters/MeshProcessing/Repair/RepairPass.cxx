// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/RepairPass.h"

#include "MeshProcessing/Cgal/CgalMesh.h"
#include "MeshProcessing/Repair/FlatTriangles.h"
#include "MeshProcessing/Repair/HoleFilling.h"
#include "MeshProcessing/Repair/SoupRepair.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshStatistics.h"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace surfsynth
{

namespace
{
namespace PMP = CGAL::Polygon_mesh_processing;

/// One pass.
class RepairPass
{
public:
  RepairPass(RepairState& state, const RepairOptions& options, double mergeTolerance, const std::atomic<bool>* stop)
    : State(state)
    , Options(options)
    , MergeTolerance(mergeTolerance)
    , Stop(stop)
  {}

  PassReport Run()
  {
    this->BuildHalfedges();
    this->RemoveDegenerateTriangles();
    this->RemoveSelfIntersections();
    this->CloseHoles();
    this->RemoveComponents();
    this->OrientOutward();
    this->Change(
      "points copied because several fans met there", PMP::duplicate_non_manifold_vertices(this->Mesh), true);
    this->StoreState();
    return std::move(this->Report);
  }

private:
  void ThrowIfStopped() const
  {
    if (this->Stop && this->Stop->load())
    {
      throw Cancelled("Stopped on request.");
    }
  }

  /// Adds a line about changes. @param isGeometric the changes may have caused others that a pass finds
  void Change(const char* what, std::int64_t count, bool isGeometric = false)
  {
    this->ThrowIfStopped();
    if (count > 0)
    {
      this->Report.Lines.push_back({ what, count, false });
      this->Report.NeedsAnother = this->Report.NeedsAnother || isGeometric;
    }
  }

  /// Adds a line about what is left.
  void Leave(const char* what, std::int64_t count)
  {
    this->ThrowIfStopped();
    if (count > 0)
    {
      this->Report.Lines.push_back({ what, count, true });
    }
  }

  void BuildHalfedges()
  {
    Soup soup{ std::move(this->State.Mesh), {} };
    soup.OriginOfTriangle.resize(static_cast<std::size_t>(soup.Mesh.Triangles.rows()));
    std::iota(soup.OriginOfTriangle.begin(), soup.OriginOfTriangle.end(), 0);
    this->RequireTriangles(soup.Mesh.NumberOfTriangles());
    const double inputArea = SurfaceArea(soup.Mesh);
    if (this->Options.MergePoints)
    {
      this->Change("points merged", MergePoints(soup, this->MergeTolerance));
    }
    const double mergedArea = SurfaceArea(soup.Mesh);
    this->Change("duplicate triangles removed", RemoveDuplicateTriangles(soup));
    this->RequireTriangles(soup.Mesh.NumberOfTriangles());
    const double duplicateArea = mergedArea - SurfaceArea(soup.Mesh);
    const ManifoldChanges changes = MakeManifold(soup);
    this->Change("triangles turned around", changes.FlippedTriangles);
    this->Change("points copied because sheets met there", changes.AddedPoints);
    this->Mesh = ToCgalMesh(soup.Mesh);
    if (changes.AddedPoints > 0 && this->Options.MergePoints)
    {
      // Two sheets that remain at an edge, after a third one was cut off, are joined again.
      this->Change("edges sewn together again", PMP::stitch_borders(this->Mesh), true);
    }
    if (changes.AddedPoints > 0)
    {
      this->Change("of these points moved apart", this->MoveApart(), true);
    }
    this->IsFilling = this->Mesh.add_property_map<CgalFace, bool>("f:filling", false).first;
    for (const CgalFace f : this->Mesh.faces())
    {
      this->IsFilling[f] = this->State.IsFilling[soup.OriginOfTriangle[f.idx()]];
    }
    this->Compact();
    this->Report.Before = MeasureExtent(FromCgalMesh(this->Mesh), CGAL::is_closed(this->Mesh));
    this->Report.Before.Area = inputArea - duplicateArea;
  }

  /// Moves points of equal coordinates, at which sheets were taken apart, a little towards their own sheet: in files
  /// without connectivity they would become one point again, and so would the patches of holes beside them.
  std::int64_t MoveApart()
  {
    std::map<std::tuple<double, double, double>, std::vector<CgalVertex>> places;
    for (const CgalVertex v : this->Mesh.vertices())
    {
      if (!this->Mesh.is_isolated(v))
      {
        const CgalPoint& point = this->Mesh.point(v);
        places[{ point.x(), point.y(), point.z() }].push_back(v);
      }
    }
    std::vector<std::pair<CgalVertex, CgalPoint>> moves;
    for (const auto& place : places)
    {
      for (const CgalVertex v : place.second)
      {
        if (place.second.size() > 1)
        {
          moves.emplace_back(v, this->TowardsItsSheet(v));
        }
      }
    }
    for (const auto& move : moves)
    {
      this->Mesh.point(move.first) = move.second;
    }
    return static_cast<std::int64_t>(moves.size());
  }

  /// The point a hundredth of the shortest edge from @p v, or further than the merge tolerance but for a quarter of that
  /// edge, in the direction in which, on the whole, its neighbours lie.
  CgalPoint TowardsItsSheet(CgalVertex v) const
  {
    const Eigen::Vector3d at = FromCgalPoint(this->Mesh.point(v));
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double shortest = std::numeric_limits<double>::infinity();
    for (const CgalHalfedge h : this->Mesh.halfedges_around_target(this->Mesh.halfedge(v)))
    {
      const Eigen::Vector3d edge = FromCgalPoint(this->Mesh.point(this->Mesh.source(h))) - at;
      shortest = std::min(shortest, edge.norm());
      direction += edge.normalized();
    }
    const double distance = std::max(0.01 * shortest, std::min(1.5 * this->Options.MergeTolerance, 0.25 * shortest));
    return ToCgalPoint(at + distance * direction.normalized());
  }

  /// Renumbers the rest without gaps, in the same order: much of CGAL relies on that.
  void Compact()
  {
    std::vector<bool> isFilling;
    for (const CgalFace f : this->Mesh.faces())
    {
      isFilling.push_back(this->IsFilling[f]);
    }
    this->Mesh = ToCgalMesh(FromCgalMesh(this->Mesh));
    this->IsFilling = this->Mesh.add_property_map<CgalFace, bool>("f:filling", false).first;
    for (const CgalFace f : this->Mesh.faces())
    {
      this->IsFilling[f] = isFilling[f.idx()];
    }
  }

  void RequireTriangles(std::int64_t count) const
  {
    if (count == 0)
    {
      throw InvalidInput("No valid triangle is left of the " + std::to_string(this->State.IsFilling.size()) +
        " triangles of the input; a surface needs polygons with three different, finite points.");
    }
  }

  /// Renews the handle after the mesh was replaced.
  void FindMarks() { this->IsFilling = this->Mesh.property_map<CgalFace, bool>("f:filling").first; }

  void RemoveDegenerateTriangles()
  {
    const std::int64_t flat = CountFlatTriangles(this->Mesh);
    if (flat > 0)
    {
      PMP::remove_degenerate_faces(this->Mesh);
      this->Compact();
      RemoveFlatTriangles(this->Mesh);
      this->Compact();
    }
    this->Change("triangles without area removed", flat, true);
    this->RequireTriangles(static_cast<std::int64_t>(this->Mesh.number_of_faces()));
  }

  void RemoveSelfIntersections()
  {
    if (!this->Options.RemoveSelfIntersections)
    {
      return;
    }
    TriangleMesh before = FromCgalMesh(this->Mesh);
    const TriangleMesh& refused = this->State.RefusedMesh;
    if (refused.NumberOfTriangles() > 0 && IsSameMesh(before, refused))
    {
      this->Report.Removal = this->State.Refused;
    }
    else
    {
      this->Report.Removal = RemoveIntersections(this->Mesh, this->Options.MaximumLoss, this->Stop);
      this->FindMarks();
    }
    const IntersectionRemoval& removal = this->Report.Removal;
    if (removal.Left < removal.Before)
    {
      this->Compact();
    }
    else if (removal.Left > 0)
    {
      this->State.RefusedMesh = std::move(before);
      this->State.Refused = removal;
    }
    this->Change("intersecting triangles removed", removal.Before - removal.Left, true);
    this->Change("small pieces removed that were cut off there", removal.Fragments, true);
    this->Leave("intersecting triangles that could not be removed", removal.Left);
  }

  double LargestHole() const
  {
    if (this->Options.LargestHole > 0.0 || !(this->Options.LargestHoleFraction > 0.0))
    {
      return this->Options.LargestHole;
    }
    const BoundingBox box = ComputeBoundingBox(FromCgalMesh(this->Mesh));
    return this->Options.LargestHoleFraction * (box.Upper - box.Lower).norm();
  }

  void CloseHoles()
  {
    if (CGAL::is_closed(this->Mesh))
    {
      return;
    }
    const double largest = this->LargestHole();
    const CgalMesh before(this->Mesh);
    FillingRequirements requirements;
    requirements.NoIntersections = this->Options.RemoveSelfIntersections;
    FilledHoles holes = FillHoles(this->Mesh, largest, this->IsFilling, this->Stop, requirements);
    if (holes.Closed > 0 && !this->RemoveFlatFillings())
    {
      this->Mesh = before;
      this->FindMarks();
      requirements.NoFlatTriangles = true;
      holes = FillHoles(this->Mesh, largest, this->IsFilling, this->Stop, requirements);
    }
    this->Compact();
    this->Change("holes closed", holes.Closed, true);
    this->Leave("boundaries left open because they are larger than the limit", holes.LeftOpen);
    this->Leave("outlines of flat pieces left open", holes.FlatOutlines);
    this->Leave(
      "holes left open because triangles that close them would intersect others or have no area", holes.Unsuitable);
    this->Report.FlatOutlines = holes.FlatOutlines;
    this->Report.Unsuitable = holes.Unsuitable;
  }

  /// @return true when no triangle without area is left
  bool RemoveFlatFillings()
  {
    this->Compact();
    if (CountFlatTriangles(this->Mesh) == 0)
    {
      return true;
    }
    RemoveFlatTriangles(this->Mesh);
    this->Compact();
    return CountFlatTriangles(this->Mesh) == 0;
  }

  SurfaceExtent Extent() const
  {
    SurfaceExtent extent = MeasureExtent(FromCgalMesh(this->Mesh), CGAL::is_closed(this->Mesh));
    for (const CgalFace f : this->Mesh.faces())
    {
      extent.Area -= this->IsFilling[f] ? PMP::face_area(f, this->Mesh) : 0.0;
    }
    return extent;
  }

  void RemoveComponents()
  {
    if (!this->Options.KeepLargestComponent && !(this->Options.SmallestComponent > 0.0))
    {
      return;
    }
    auto component = this->Mesh.add_property_map<CgalFace, std::size_t>("f:component", 0).first;
    const std::size_t count = PMP::connected_components(this->Mesh, component);
    std::vector<double> area(count, 0.0);
    for (const CgalFace f : this->Mesh.faces())
    {
      area[component[f]] += PMP::face_area(f, this->Mesh);
    }
    const auto largest = std::max_element(area.begin(), area.end());
    std::vector<std::size_t> kept;
    for (std::size_t c = 0; c < count; ++c)
    {
      const bool isLargest = c == static_cast<std::size_t>(largest - area.begin());
      if (isLargest || (!this->Options.KeepLargestComponent && area[c] >= this->Options.SmallestComponent * *largest))
      {
        kept.push_back(c);
      }
    }
    const SurfaceExtent before = this->Extent();
    PMP::keep_connected_components(this->Mesh, kept, component);
    this->Mesh.remove_property_map(component);
    this->Compact();
    const SurfaceExtent after = this->Extent();
    this->Report.Removed.Area = before.Area - after.Area;
    this->Report.Removed.Volume = before.IsClosed ? before.Volume - after.Volume : 0.0;
    this->Report.Removed.Components = before.Components - after.Components;
    this->Change("components removed", static_cast<std::int64_t>(count - kept.size()), true);
  }

  void OrientOutward()
  {
    if (!this->Options.OrientOutward || !CGAL::is_closed(this->Mesh))
    {
      return;
    }
    auto before = this->Mesh.add_property_map<CgalFace, CgalVertex>("f:before").first;
    const auto secondCorner = [&](CgalFace f) {
      // The vertex after the lowest one, which tells one winding from the other.
      CgalHalfedge lowest = this->Mesh.halfedge(f);
      for (const CgalHalfedge h : this->Mesh.halfedges_around_face(lowest))
      {
        lowest = this->Mesh.target(h) < this->Mesh.target(lowest) ? h : lowest;
      }
      return this->Mesh.target(this->Mesh.next(lowest));
    };
    for (const CgalFace f : this->Mesh.faces())
    {
      before[f] = secondCorner(f);
    }
    // Nesting is only defined without self-intersections; with them each component is oriented by itself.
    try
    {
      PMP::does_self_intersect(this->Mesh) ? PMP::orient(this->Mesh) : PMP::orient_to_bound_a_volume(this->Mesh);
    }
    catch (const CGAL::Failure_exception&)
    {
      // A component without volume, such as a flat piece whose boundary was closed, has no outside: the winding stays.
    }
    std::int64_t turned = 0;
    for (const CgalFace f : this->Mesh.faces())
    {
      turned += before[f] != secondCorner(f) ? 1 : 0;
    }
    this->Mesh.remove_property_map(before);
    this->Change("triangles turned to face outward", turned);
  }

  void StoreState()
  {
    this->State.Mesh = FromCgalMesh(this->Mesh);
    this->State.IsClosed = CGAL::is_closed(this->Mesh);
    this->State.IsFilling.clear();
    for (const CgalFace f : this->Mesh.faces())
    {
      this->State.IsFilling.push_back(this->IsFilling[f]);
    }
    if (this->Options.SinglePrecision)
    {
      const PointMatrix rounded = this->State.Mesh.Points.cast<float>().cast<double>();
      this->Report.NeedsAnother = this->Report.NeedsAnother || rounded != this->State.Mesh.Points;
      this->State.Mesh.Points = rounded;
    }
  }

  RepairState& State;
  const RepairOptions& Options;
  double MergeTolerance;
  const std::atomic<bool>* Stop;
  CgalMesh Mesh;
  CgalMesh::Property_map<CgalFace, bool> IsFilling;
  PassReport Report;
};
} // namespace

bool IsSameMesh(const TriangleMesh& a, const TriangleMesh& b)
{
  return a.Points.rows() == b.Points.rows() && a.Triangles.rows() == b.Triangles.rows() && a.Points == b.Points &&
    a.Triangles == b.Triangles;
}

PassReport RunRepairPass(
  RepairState& state, const RepairOptions& options, double mergeTolerance, const std::atomic<bool>* stop)
{
  return RepairPass(state, options, mergeTolerance, stop).Run();
}

} // namespace surfsynth
