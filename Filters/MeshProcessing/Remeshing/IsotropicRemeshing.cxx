// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"

#include "MeshProcessing/Remeshing/RemeshingCurves.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <string>

namespace surfsynth
{

namespace
{
void StopIfAsked(const std::atomic<bool>* stop)
{
  if (stop && stop->load())
  {
    throw Cancelled("Stopped on request.");
  }
}

/// The mesh before remeshing: for each corner of a triangle, its point and its class; points of one class may be
/// merged.
class InputSurface
{
public:
  InputSurface(const TriangleMesh& mesh, const RemeshingOptions& options)
    : Mesh(mesh)
    , Finder(options.Finder)
    , Classes(options.PointClasses)
  {}

  /// Key of a place: the classes and shares of the corners with a weight. Places with equal keys are the same point.
  using Key = std::vector<Index>;
  Key KeyOf(const SurfacePlace& place) const
  {
    Key key;
    for (int k = 0; k < 3; ++k)
    {
      if (place.Weights[k] > 1e-7)
      {
        const Index point = this->Mesh.Triangles(place.Triangle, k);
        key.push_back(this->Classes.empty() ? point : this->Classes[point]);
      }
    }
    std::sort(key.begin(), key.end());
    return key;
  }

  Eigen::Vector3d Center(Index f) const
  {
    const auto t = this->Mesh.Triangles.row(f);
    return (this->Mesh.Points.row(t(0)) + this->Mesh.Points.row(t(1)) + this->Mesh.Points.row(t(2))).transpose() / 3.0;
  }

  const TriangleMesh& Mesh;
  const PlaceFinder& Finder;

private:
  const std::vector<Index>& Classes;
};

/// Converts the remeshed halfedges to a mesh, with the place of each point on the input.
class Harvest
{
public:
  Harvest(const InputSurface& input, const CurvedMesh& remeshed, const OriginalCurves& curves)
    : Input(input)
    , Mesh(remeshed.Mesh)
    , IsCurve(remeshed.Constraints.IsCurve)
    , Curves(curves)
    , PointOfCorner(this->Mesh.num_halfedges(), -1)
  {}

  RemeshedSurface Result(bool findPlaces, bool findOrigins)
  {
    this->AddPoints();
    this->AddTriangles();
    if (findPlaces || findOrigins)
    {
      this->Locate(findPlaces, findOrigins);
    }
    return std::move(this->Surface);
  }

private:
  bool OnCurve(CgalHalfedge h) const
  {
    return this->Mesh.is_border(this->Mesh.edge(h)) || this->IsCurve[this->Mesh.edge(h)];
  }

  void AddPoints()
  {
    for (const CgalVertex v : this->Mesh.vertices())
    {
      const auto around = this->Mesh.halfedges_around_target(this->Mesh.halfedge(v));
      if (this->Mesh.is_isolated(v))
      {
        continue;
      }
      if (std::any_of(around.begin(), around.end(), [&](CgalHalfedge h) { return this->OnCurve(h); }))
      {
        this->AddPointsOnCurve(v);
        continue;
      }
      const Index point = this->AddPoint(FromCgalPoint(this->Mesh.point(v)), SurfacePlace());
      for (const CgalHalfedge h : around)
      {
        this->PointOfCorner[h.idx()] = point;
      }
    }
  }

  Index AddPoint(const Eigen::Vector3d& point, const SurfacePlace& place)
  {
    this->Points.push_back(point);
    this->Surface.PlaceOfPoint.push_back(place);
    return static_cast<Index>(this->Points.size()) - 1;
  }

  /// A point for each fan of triangles between the curves at @p v, where their attributes come from different points.
  void AddPointsOnCurve(CgalVertex v)
  {
    const OriginalCurves::Foot foot = this->Curves.Nearest(FromCgalPoint(this->Mesh.point(v)));
    std::map<InputSurface::Key, Index> points;
    for (const std::vector<CgalHalfedge>& fan : this->FansAround(v))
    {
      const SurfacePlace place = this->PlaceInDirection(foot, this->Direction(v, fan));
      const auto made = points.insert({ this->Input.KeyOf(place), -1 });
      if (made.second)
      {
        made.first->second = this->AddPoint(foot.Point, place);
      }
      for (const CgalHalfedge h : fan)
      {
        this->PointOfCorner[h.idx()] = made.first->second;
      }
    }
  }

  /// The corners at @p v, halfedges towards it inside triangles, grouped between curves.
  std::vector<std::vector<CgalHalfedge>> FansAround(CgalVertex v) const
  {
    // next(h) leaves v; its opposite is the next halfedge towards v. A fan begins where h lies on a curve.
    CgalHalfedge first = this->Mesh.halfedge(v);
    while (!this->OnCurve(first))
    {
      first = this->Mesh.opposite(this->Mesh.next(first));
    }
    std::vector<std::vector<CgalHalfedge>> fans;
    CgalHalfedge h = first;
    do
    {
      if (this->OnCurve(h))
      {
        fans.emplace_back();
      }
      if (!this->Mesh.is_border(h))
      {
        fans.back().push_back(h);
      }
      h = this->Mesh.opposite(this->Mesh.next(h));
    } while (h != first);
    fans.erase(std::remove_if(fans.begin(), fans.end(), [](const auto& fan) { return fan.empty(); }), fans.end());
    return fans;
  }

  /// The mean direction in which the triangles of a fan lie, seen from @p v.
  Eigen::Vector3d Direction(CgalVertex v, const std::vector<CgalHalfedge>& fan) const
  {
    const Eigen::Vector3d at = FromCgalPoint(this->Mesh.point(v));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const CgalHalfedge h : fan)
    {
      for (const CgalVertex other : { this->Mesh.source(h), this->Mesh.target(this->Mesh.next(h)) })
      {
        sum += (FromCgalPoint(this->Mesh.point(other)) - at).normalized();
      }
    }
    return sum;
  }

  /// The place of the foot on the triangle of the input that lies most in @p direction.
  SurfacePlace PlaceInDirection(const OriginalCurves::Foot& foot, const Eigen::Vector3d& direction) const
  {
    Index best = foot.Triangles.front();
    double largest = -2.0;
    for (const Index f : foot.Triangles)
    {
      const double along = (this->Input.Center(f) - foot.Point).normalized().dot(direction.normalized());
      if (along > largest)
      {
        largest = along;
        best = f;
      }
    }
    return NearestOnTriangle(this->Input.Mesh, best, foot.Point);
  }

  void AddTriangles()
  {
    auto& triangles = this->Surface.Mesh.Triangles;
    triangles.resize(this->Mesh.number_of_faces(), 3);
    Index f = 0;
    for (const CgalFace face : this->Mesh.faces())
    {
      int k = 0;
      for (const CgalHalfedge h : this->Mesh.halfedges_around_face(this->Mesh.halfedge(face)))
      {
        triangles(f, k++) = this->PointOfCorner[h.idx()];
      }
      ++f;
    }
    auto& points = this->Surface.Mesh.Points;
    points.resize(static_cast<Eigen::Index>(this->Points.size()), 3);
    for (std::size_t v = 0; v < this->Points.size(); ++v)
    {
      points.row(static_cast<Eigen::Index>(v)) = this->Points[v].transpose();
    }
  }

  /// Finds the places of points that lie on no curve, and the origins of triangles, of which there are twice as many:
  /// each costs a search.
  void Locate(bool points, bool triangles)
  {
    std::vector<Index> free;
    for (std::size_t v = 0; points && v < this->Points.size(); ++v)
    {
      if (this->Surface.PlaceOfPoint[v].Triangle < 0)
      {
        free.push_back(static_cast<Index>(v));
      }
    }
    const TriangleMesh& made = this->Surface.Mesh;
    const auto numberFree = static_cast<Eigen::Index>(free.size());
    PointMatrix wanted(numberFree + (triangles ? made.NumberOfTriangles() : 0), 3);
    for (Eigen::Index k = 0; k < numberFree; ++k)
    {
      wanted.row(k) = made.Points.row(free[static_cast<std::size_t>(k)]);
    }
    for (Index f = 0; triangles && f < made.NumberOfTriangles(); ++f)
    {
      const auto corner = [&](int k) { return made.Points.row(made.Triangles(f, k)); };
      wanted.row(numberFree + f) = (corner(0) + corner(1) + corner(2)) / 3.0;
    }
    const std::vector<SurfacePlace> places = this->Input.Finder(this->Input.Mesh, wanted);
    for (std::size_t k = 0; k < free.size(); ++k)
    {
      this->Surface.PlaceOfPoint[free[k]] = places[k];
    }
    std::transform(places.begin() + numberFree, places.end(), std::back_inserter(this->Surface.OriginOfTriangle),
      [](const SurfacePlace& place) { return place.Triangle; });
  }

  const InputSurface& Input;
  const CgalMesh& Mesh;
  CgalMesh::Property_map<CgalEdge, bool> IsCurve;
  const OriginalCurves& Curves;
  std::vector<Index> PointOfCorner; ///< by halfedge, for the corner at its target
  std::vector<Eigen::Vector3d> Points;
  RemeshedSurface Surface;
};

/// One remeshing with edge lengths multiplied by @p scale. With @p refineFirst the outcome does not depend on how close
/// the input's edges are to the target, between the bounds at which edges are split and collapsed.
RemeshedSurface Remesh(
  const TriangleMesh& mesh, RemeshingOptions options, double scale, bool refineFirst, const std::atomic<bool>* stop)
{
  options.EdgeLength *= scale;
  std::for_each(
    options.PointEdgeLengths.begin(), options.PointEdgeLengths.end(), [scale](double& length) { length *= scale; });
  CurvedMesh curved(mesh, options);
  const OriginalCurves curves(curved);
  StopIfAsked(stop);
  if (options.PointEdgeLengths.empty())
  {
    if (refineFirst)
    {
      CGAL::Polygon_mesh_processing::split_long_edges(curved.Mesh.edges(), 0.5 * options.EdgeLength, curved.Mesh,
        CGAL::parameters::edge_is_constrained_map(curved.Constraints.IsCurve));
    }
    CGAL::Polygon_mesh_processing::isotropic_remeshing(curved.Mesh.faces(), options.EdgeLength, curved.Mesh,
      CGAL::parameters::number_of_iterations(options.NumberOfIterations)
        .edge_is_constrained_map(curved.Constraints.IsCurve)
        .vertex_is_constrained_map(curved.Constraints.IsFixed)
        .number_of_relaxation_steps(options.NumberOfRelaxationSteps));
  }
  else
  {
    RemeshAdaptively(curved.Mesh, curved.Constraints, options.PointEdgeLengths, options.NumberOfIterations,
      options.NumberOfRelaxationSteps, stop);
  }
  StopIfAsked(stop);
  return Harvest(InputSurface(mesh, options), curved, curves).Result(options.FindPlaces, options.FindOrigins);
}

/// @throws InvalidInput when the result would have too many points, or triangles larger than the surface.
void RequireFeasible(const TriangleMesh& mesh, const RemeshingOptions& options)
{
  const std::string limit = FormatNumber(options.MaximumNumberOfPoints) + " (MaximumNumberOfPoints)";
  if (options.NumberOfPoints > 0)
  {
    if (static_cast<double>(options.NumberOfPoints) > options.MaximumNumberOfPoints)
    {
      throw InvalidInput("Remeshing with " + std::to_string(options.NumberOfPoints) +
        " points was asked for; at most " + limit + " are allowed.");
    }
    return;
  }
  const bool sized = !options.PointEdgeLengths.empty();
  const double points = ExpectedNumberOfPoints(mesh, options);
  const std::string length = FormatNumber(options.EdgeLength);
  if (points > options.MaximumNumberOfPoints)
  {
    // The number decreases with the square of the length; a little is added, so that the length in the message fits.
    const double factor = 1.01 * std::sqrt(points / options.MaximumNumberOfPoints);
    throw InvalidInput("About " + FormatNumber(points) + " points would be needed for " +
      (sized ? std::string("the edge lengths asked for") : "edges of length " + length) + "; at most " + limit +
      " are allowed. " +
      (sized ? "Lengths " + FormatNumber(factor) + " times as large fit."
             : "A length of " + FormatNumber(factor * options.EdgeLength) + " fits."));
  }
  const BoundingBox box = ComputeBoundingBox(mesh);
  if (!sized && options.EdgeLength > 1.0001 * (box.Upper - box.Lower).norm()) // no edge of the input is longer
  {
    throw InvalidInput("Edges of length " + length + " are longer than the surface, whose longest side is " +
      FormatNumber(box.LongestSide()) + "; a shorter length, in the units of the surface, is needed.");
  }
}

/// Ratio of the target to the mean edge length after the rounds: edges are about 8 per cent shorter.
constexpr double ShortenedBy = 1.08;

/// A goal of a remeshing: a measure of the result and its wanted value.
struct Goal
{
  double Wanted = 0.0;
  std::function<double(const TriangleMesh& made)> Measure;
  double PowerOfLength = 0.0; ///< the measure goes with this power of the edge length
};

/// The best of up to six remeshings, the first one with edge lengths multiplied by @p scale, until one is within 2 per
/// cent of the goal.
RemeshedSurface RemeshTowards(const Goal& goal, double scale, const TriangleMesh& mesh, const RemeshingOptions& options,
  const std::atomic<bool>* stop)
{
  RemeshedSurface best;
  double bestError = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < 6 && bestError > 0.02; ++attempt)
  {
    RemeshedSurface made = Remesh(mesh, options, scale, attempt > 0, stop);
    const double found = goal.Measure(made.Mesh);
    scale *= std::pow(goal.Wanted / found, 1.0 / goal.PowerOfLength);
    const double error = std::abs(found - goal.Wanted) / goal.Wanted;
    if (error < bestError)
    {
      bestError = error;
      best = std::move(made);
    }
  }
  return best;
}
} // namespace

RemeshedSurface RemeshIsotropically(
  const TriangleMesh& mesh, const RemeshingOptions& options, const std::atomic<bool>* stop)
{
  RequireFeasible(mesh, options);
  if (options.NumberOfPoints > 0)
  {
    Goal goal;
    goal.Wanted = static_cast<double>(options.NumberOfPoints);
    goal.Measure = [](const TriangleMesh& made) { return static_cast<double>(made.NumberOfPoints()); };
    goal.PowerOfLength = -2.0;
    const double scale = ShortenedBy * std::sqrt(ExpectedNumberOfPoints(mesh, options) / goal.Wanted);
    return RemeshTowards(goal, scale, mesh, options, stop);
  }
  if (options.MatchMeanEdgeLength && options.PointEdgeLengths.empty())
  {
    Goal goal;
    goal.Wanted = options.EdgeLength;
    goal.Measure = MeanSideLength;
    goal.PowerOfLength = 1.0;
    return RemeshTowards(goal, ShortenedBy, mesh, options, stop);
  }
  return Remesh(mesh, options, options.MatchMeanEdgeLength ? ShortenedBy : 1.0, false, stop);
}

double ExpectedNumberOfPoints(const TriangleMesh& mesh, const RemeshingOptions& options)
{
  double points = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d a = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
    const Eigen::Vector3d b = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
    double length = options.EdgeLength;
    if (!options.PointEdgeLengths.empty())
    {
      length = (options.PointEdgeLengths[t(0)] + options.PointEdgeLengths[t(1)] + options.PointEdgeLengths[t(2)]) / 3.0;
    }
    points += 0.5 * (0.5 * a.cross(b).norm()) / (std::sqrt(3.0) / 4.0 * length * length);
  }
  return points;
}

} // namespace surfsynth
