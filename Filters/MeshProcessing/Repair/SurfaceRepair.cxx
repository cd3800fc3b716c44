// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/SurfaceRepair.h"

#include "MeshProcessing/Cgal/CgalMesh.h"
#include "MeshProcessing/Repair/HoleFilling.h"
#include "MeshProcessing/Repair/SoupRepair.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Text.h"
#include "Core/Mesh/MeshCheck.h"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

namespace surfsynth
{

namespace
{
namespace PMP = CGAL::Polygon_mesh_processing;

constexpr double LargestCoordinate = 1e90;

/// One run of RepairSurface().
class SurfaceRepairer
{
public:
  SurfaceRepairer(const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options,
    const std::atomic<bool>* stop)
    : Input(mesh)
    , Losses(losses)
    , Options(options)
    , Stop(stop)
  {}

  RepairedSurface Result()
  {
    this->RequireModestCoordinates();
    this->ReportConversion();
    this->BuildHalfedges();
    this->RemoveDegenerateTriangles();
    this->RemoveSelfIntersections();
    this->CloseHoles();
    this->RemoveComponents();
    this->OrientOutward();
    this->Note("points copied because several fans met there", PMP::duplicate_non_manifold_vertices(this->Mesh));
    this->Collect();
    return std::move(this->Surface);
  }

private:
  void Note(const char* what, std::int64_t count)
  {
    if (this->Stop && this->Stop->load())
    {
      throw Cancelled("Stopped on request.");
    }
    if (count > 0)
    {
      this->Surface.Report.emplace_back(what, count);
    }
  }

  void ReportConversion()
  {
    this->Note("cells left out that name a point which does not exist", this->Losses.CellsOutOfRange);
    this->Note("points with a NaN or infinite coordinate left out", this->Losses.NonFinitePoints);
    this->Note("cells left out because they used such points", this->Losses.CellsNotFinite);
    this->Note("polygons and strips without three different points left out", this->Losses.CellsTooSmall);
    this->Note("polygons that used a point twice", this->Losses.RepeatedPoints);
    this->Note("polygons without a simple outline cut into triangles", this->Losses.PolygonsNotSimple);
  }

  void BuildHalfedges()
  {
    Soup soup{ this->Input, {} };
    soup.OriginOfTriangle.resize(static_cast<std::size_t>(soup.Mesh.Triangles.rows()));
    std::iota(soup.OriginOfTriangle.begin(), soup.OriginOfTriangle.end(), 0);
    this->RequireTriangles(soup.Mesh.NumberOfTriangles());
    if (this->Options.MergePoints)
    {
      this->Note("points merged", MergePoints(soup, this->Options.MergeTolerance));
    }
    this->Note("duplicate triangles removed", RemoveDuplicateTriangles(soup));
    this->RequireTriangles(soup.Mesh.NumberOfTriangles());
    const ManifoldChanges changes = MakeManifold(soup);
    this->Note("triangles turned around", changes.FlippedTriangles);
    this->Note("points copied because sheets met there", changes.AddedPoints);
    this->Mesh = ToCgalMesh(soup.Mesh);
    if (changes.AddedPoints > 0 && this->Options.MergePoints)
    {
      // Where a third sheet was cut off, the two that remain belong together again.
      this->Note("edges sewn together again", PMP::stitch_borders(this->Mesh));
    }
    if (changes.AddedPoints > 0)
    {
      this->Note("of these points moved apart", this->MoveApart());
    }
    this->IsFilling = this->Mesh.add_property_map<CgalFace, bool>("f:filling", false).first;
    this->Compact();
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

  /// The point a hundredth of an edge from @p v in the direction in which, on the whole, its neighbours lie.
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
    return ToCgalPoint(at + 0.01 * shortest * direction.normalized());
  }

  /// Numbers what is left without gaps, in the same order: much of CGAL relies on that.
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

  /// Squares and cubes of coordinates must be finite numbers.
  void RequireModestCoordinates() const
  {
    const double largest = this->Input.Points.size() > 0 ? this->Input.Points.cwiseAbs().maxCoeff() : 0.0;
    if (largest > LargestCoordinate)
    {
      throw InvalidInput("The points have coordinates up to " + Text(largest) + "; at most " + Text(LargestCoordinate) +
        " is allowed. vtkTransformPolyDataFilter scales them.");
    }
  }

  void RequireTriangles(std::int64_t count) const
  {
    if (count == 0)
    {
      throw InvalidInput("No valid triangle is left of the " + std::to_string(this->Input.NumberOfTriangles()) +
        " triangles of the input; a surface needs polygons with three different, finite points.");
    }
  }

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
    this->Note("triangles without area removed", flat);
    this->RequireTriangles(static_cast<std::int64_t>(this->Mesh.number_of_faces()));
  }

  void RemoveSelfIntersections()
  {
    if (!this->Options.RemoveSelfIntersections)
    {
      return;
    }
    const std::int64_t before = this->CountSelfIntersections();
    if (before > 0)
    {
      PMP::experimental::remove_self_intersections(this->Mesh, CGAL::parameters::preserve_genus(false));
      this->Compact();
      const std::int64_t after = this->CountSelfIntersections();
      this->Note("self-intersections removed", std::max<std::int64_t>(before - after, 0));
      this->Note("self-intersections that could not be removed", after);
    }
  }

  std::int64_t CountSelfIntersections() const
  {
    std::vector<std::pair<CgalFace, CgalFace>> pairs;
    PMP::self_intersections(this->Mesh, std::back_inserter(pairs));
    return static_cast<std::int64_t>(pairs.size());
  }

  void CloseHoles()
  {
    const FilledHoles holes = FillHoles(this->Mesh, this->Options.LargestHole, this->IsFilling, this->Stop);
    this->Compact();
    this->Note("holes closed", holes.Closed);
    this->Note("boundaries left open because they are larger than the limit", holes.LeftOpen);
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
    PMP::keep_connected_components(this->Mesh, kept, component);
    this->Compact();
    this->Note("components removed", static_cast<std::int64_t>(count - kept.size()));
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
    // What lies inside what is only defined where nothing crosses; else each component is turned by itself.
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
    this->Note("triangles turned to face outward", turned);
  }

  void Collect()
  {
    this->Surface.Mesh = FromCgalMesh(this->Mesh);
    MeshRequirements requirements;
    requirements.ManifoldVertices = true;
    requirements.ConsistentWinding = true;
    const std::vector<MeshFinding> findings = CheckMesh(this->Surface.Mesh, requirements);
    if (!findings.empty())
    {
      throw SolverFailure("The surface could not be repaired. What is left has " + DescribeFindings(findings) +
        " vtkVDBSurfaceFilter makes a closed surface of any triangles.");
    }
    for (const CgalFace f : this->Mesh.faces())
    {
      this->Surface.IsFilling.push_back(this->IsFilling[f]);
    }
    this->Locate();
  }

  void Locate()
  {
    const TriangleMesh& mesh = this->Surface.Mesh;
    const Eigen::Index points = mesh.Points.rows();
    PointMatrix wanted(points + mesh.Triangles.rows(), 3);
    wanted.topRows(points) = mesh.Points;
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const auto t = mesh.Triangles.row(f);
      wanted.row(points + f) = (mesh.Points.row(t(0)) + mesh.Points.row(t(1)) + mesh.Points.row(t(2))) / 3.0;
    }
    this->Surface.PlaceOfPoint = this->Options.Finder(this->Input, wanted);
    this->Surface.OriginOfTriangle.resize(static_cast<std::size_t>(mesh.Triangles.rows()));
    std::transform(this->Surface.PlaceOfPoint.begin() + points, this->Surface.PlaceOfPoint.end(),
      this->Surface.OriginOfTriangle.begin(), [](const SurfacePlace& place) { return place.Triangle; });
    this->Surface.PlaceOfPoint.resize(static_cast<std::size_t>(points));
  }

  const TriangleMesh& Input;
  const ConversionLosses& Losses;
  const RepairOptions& Options;
  const std::atomic<bool>* Stop;
  CgalMesh Mesh;
  CgalMesh::Property_map<CgalFace, bool> IsFilling;
  RepairedSurface Surface;
};
} // namespace

RepairedSurface RepairSurface(
  const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options, const std::atomic<bool>* stop)
{
  return SurfaceRepairer(mesh, losses, options, stop).Result();
}

} // namespace surfsynth
