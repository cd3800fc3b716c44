// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SurfaceSimplification.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/NearestWeights.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <string>

namespace surfsynth
{

namespace
{
using Corners = std::array<Index, 3>;

constexpr double Pi = 3.14159265358979323846;
constexpr std::size_t MostTrianglesAround = 100; ///< of a vertex that goes: corners of a Piece are 8 bits
constexpr std::size_t MostTrianglesAfter = 9;    ///< of the vertex that stays, without a penalty
constexpr double LeastPlaneShape = 0.02;         ///< of a triangle in the plane
/// Weight of the way from a vertex to the triangles after its collapse, beside the length of the edge: keeps tips and ridges.
constexpr double HeightWeight = 3.0;
constexpr double LeastShape = 0.05; ///< in the weight of an edge

/// Shape of a triangle by its area and the squares of its sides: 1 for an equilateral one, 0 without area, negative turned over.
double ShapeOf(double area, double squares) { return squares > 0.0 ? 4.0 * std::sqrt(3.0) * area / squares : 0.0; }

double PlaneShape(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c)
{
  const Eigen::Vector2d u = b - a;
  const Eigen::Vector2d v = c - a;
  return ShapeOf(0.5 * (u.x() * v.y() - u.y() * v.x()), u.squaredNorm() + v.squaredNorm() + (c - b).squaredNorm());
}

double SpaceShape(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, const Eigen::RowVector3d& c)
{
  const double area = 0.5 * (b - a).cross(c - a).norm();
  return ShapeOf(area, (b - a).squaredNorm() + (c - a).squaredNorm() + (c - b).squaredNorm());
}

double DistanceToTriangle(const Eigen::RowVector3d& point, const Eigen::RowVector3d& a, const Eigen::RowVector3d& b,
  const Eigen::RowVector3d& c)
{
  const std::array<Eigen::Vector3d, 3> corners{ a.transpose(), b.transpose(), c.transpose() };
  const Eigen::Vector3d weights = NearestWeights(corners, point.transpose());
  return (weights[0] * a + weights[1] * b + weights[2] * c - point).norm();
}

double AngleAt(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, const Eigen::RowVector3d& c)
{
  return std::atan2((b - a).cross(c - a).norm(), (b - a).dot(c - a));
}

/// The triangles around a vertex in order. Triangle k lies between neighbours k and k + 1.
struct Star
{
  std::vector<Index> Triangles;
  std::vector<Index> Neighbors; ///< one more than triangles on a boundary, else as many
  bool OnBoundary = false;

  Index Neighbor(std::size_t k) const { return this->Neighbors[k % this->Neighbors.size()]; }
};

/// A triangle in the plane; corners are ids of points, in the order of the corners of the mesh.
struct Piece
{
  Index Triangle;
  std::array<std::uint8_t, 3> Corners;
};

/// One collapse: the same part of the plane, covered by triangles before and after.
struct Collapse
{
  std::vector<Eigen::Vector2d> Points;
  std::vector<Piece> Before;
  std::vector<Piece> After;
};

/// Barycentric coordinates of @p point in a triangle of the plane.
Eigen::Vector3d WeightsIn(const Collapse& collapse, const Piece& piece, const Eigen::Vector2d& point)
{
  const Eigen::Vector2d& a = collapse.Points[piece.Corners[0]];
  const Eigen::Vector2d u = collapse.Points[piece.Corners[1]] - a;
  const Eigen::Vector2d v = collapse.Points[piece.Corners[2]] - a;
  const Eigen::Vector2d w = point - a;
  const double area = u.x() * v.y() - u.y() * v.x();
  if (!(area > 0.0))
  {
    return { 1.0, 0.0, -std::numeric_limits<double>::infinity() };
  }
  const double second = (w.x() * v.y() - w.y() * v.x()) / area;
  const double third = (u.x() * w.y() - u.y() * w.x()) / area;
  return { 1.0 - second - third, second, third };
}

/// The place among the triangles before a collapse.
SurfacePlace PlaceBefore(const Collapse& collapse, const Piece& after, const Eigen::Vector3d& weights)
{
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    point += weights[k] * collapse.Points[after.Corners[k]];
  }
  SurfacePlace found;
  double inside = -std::numeric_limits<double>::infinity();
  for (const Piece& piece : collapse.Before)
  {
    const Eigen::Vector3d here = WeightsIn(collapse, piece, point);
    if (here.minCoeff() > inside || found.Triangle < 0)
    {
      inside = here.minCoeff();
      found = { piece.Triangle, here };
    }
  }
  found.Weights = found.Weights.cwiseMax(0.0); // rounding
  found.Weights /= found.Weights.sum();
  return found;
}
} // namespace

/// The mesh under simplification, and the collapses so far.
class SurfaceSimplification::Internals
{
public:
  explicit Internals(const TriangleMesh& mesh)
    : Points(mesh.Points)
    , Triangles(static_cast<std::size_t>(mesh.NumberOfTriangles()))
    , TrianglesAround(static_cast<std::size_t>(mesh.NumberOfPoints()))
    , Version(static_cast<std::size_t>(mesh.NumberOfPoints()), 0)
    , Left(mesh.NumberOfTriangles())
  {
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        this->Triangles[f][k] = mesh.Triangles(f, k);
        this->TrianglesAround[mesh.Triangles(f, k)].push_back(f);
      }
    }
  }

  void Simplify(Index wanted, const Progress& progress)
  {
    const Index all = this->Left;
    for (Index v = 0; v < static_cast<Index>(this->Version.size()); ++v)
    {
      this->Consider(v);
    }
    std::int64_t steps = 0;
    while (this->Left > wanted && !this->Queue.empty())
    {
      const Candidate next = this->Queue.top();
      this->Queue.pop();
      if (next.Version != this->Version[next.Vertex])
      {
        continue;
      }
      const Star star = this->StarOf(next.Vertex);
      const auto m = static_cast<std::size_t>(
        std::find(star.Neighbors.begin(), star.Neighbors.end(), next.Target) - star.Neighbors.begin());
      if (!this->KeepsTopology(star, m)) // since the vertex came into the queue, an edge has come farther away
      {
        this->Consider(next.Vertex);
        continue;
      }
      this->Remove(next.Vertex, star, m);
      if (++steps % 1000 == 0)
      {
        Report(progress, static_cast<double>(all - this->Left) / static_cast<double>(all - wanted + 1));
      }
    }
    this->Collect();
  }

  TriangleMesh Result;
  std::vector<Index> OriginalOf;      ///< triangle of the simplification for each one of the result
  std::vector<Index> OriginalOfPoint; ///< point of the simplification for each one of the result

  /// Moves @p places from the result to the mesh of before.
  std::vector<SurfacePlace> Undo(const std::vector<SurfacePlace>& places) const
  {
    std::vector<SurfacePlace> moved(places.size());
    std::vector<std::vector<std::size_t>> in(this->Triangles.size());
    for (std::size_t k = 0; k < places.size(); ++k)
    {
      moved[k] = { this->OriginalOf[places[k].Triangle], places[k].Weights };
      in[moved[k].Triangle].push_back(k);
    }
    std::vector<std::size_t> here;
    for (auto collapse = this->Collapses.rbegin(); collapse != this->Collapses.rend(); ++collapse)
    {
      here.clear();
      for (const Piece& piece : collapse->After)
      {
        for (const std::size_t k : in[piece.Triangle])
        {
          moved[k] = PlaceBefore(*collapse, piece, moved[k].Weights);
          here.push_back(k);
        }
        in[piece.Triangle].clear();
      }
      for (const std::size_t k : here)
      {
        in[moved[k].Triangle].push_back(k);
      }
    }
    return moved;
  }

private:
  struct Candidate
  {
    double Cost;
    Index Vertex;
    Index Target;
    std::int64_t Version;

    bool operator<(const Candidate& other) const // the cheapest is on top of the queue
    {
      return this->Cost != other.Cost ? this->Cost > other.Cost : this->Vertex > other.Vertex;
    }
  };

  Star StarOf(Index v) const
  {
    Star star;
    std::vector<std::array<Index, 3>> sides; // from, to, triangle
    for (const Index f : this->TrianglesAround[v])
    {
      const Corners& corners = this->Triangles[f];
      const auto at = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
      sides.push_back({ corners[(at + 1) % 3], corners[(at + 2) % 3], f });
    }
    const auto sideFrom = [&](Index from) {
      return std::find_if(sides.begin(), sides.end(), [from](const auto& side) { return side[0] == from; });
    };
    auto first = sides.begin();
    for (auto side = sides.begin(); side != sides.end(); ++side)
    {
      const bool isEnd = std::none_of(
        sides.begin(), sides.end(), [&](const auto& other) { return other[1] == (*side)[0]; });
      if (isEnd)
      {
        star.OnBoundary = true;
        first = side;
      }
    }
    for (auto side = first; star.Triangles.size() < sides.size(); side = sideFrom((*side)[1]))
    {
      star.Triangles.push_back((*side)[2]);
      star.Neighbors.push_back((*side)[0]);
      if (star.OnBoundary && star.Triangles.size() == sides.size())
      {
        star.Neighbors.push_back((*side)[1]);
      }
    }
    return star;
  }

  /// The neighbours in the plane around the vertex at the origin, which comes last.
  std::vector<Eigen::Vector2d> LayOut(Index v, const Star& star) const
  {
    std::vector<double> angle(star.Triangles.size() + 1, 0.0);
    const Eigen::RowVector3d center = this->Points.row(v);
    for (std::size_t k = 0; k < star.Triangles.size(); ++k)
    {
      angle[k + 1] = angle[k] +
        AngleAt(center, this->Points.row(star.Neighbor(k)), this->Points.row(star.Neighbor(k + 1)));
    }
    const double scale = (star.OnBoundary ? Pi : 2.0 * Pi) / angle.back();
    std::vector<Eigen::Vector2d> plane;
    for (std::size_t k = 0; k < star.Neighbors.size(); ++k)
    {
      const double radius = (this->Points.row(star.Neighbors[k]) - center).norm();
      plane.emplace_back(radius * std::cos(scale * angle[k]), radius * std::sin(scale * angle[k]));
    }
    if (star.OnBoundary)
    {
      plane.back().y() = 0.0;
    }
    plane.emplace_back(0.0, 0.0);
    return plane;
  }

  bool HasEdge(Index a, Index b) const
  {
    return std::any_of(this->TrianglesAround[a].begin(), this->TrianglesAround[a].end(), [&](Index f) {
      const Corners& corners = this->Triangles[f];
      return std::find(corners.begin(), corners.end(), b) != corners.end();
    });
  }

  bool HasTriangle(const std::vector<Index>& corners) const
  {
    const auto& around = this->TrianglesAround[corners[0]];
    return std::any_of(around.begin(), around.end(), [&](Index f) {
      const Corners& present = this->Triangles[f];
      return std::is_permutation(present.begin(), present.end(), corners.begin());
    });
  }

  /// True when the collapse of @p star to its neighbour @p m keeps the topology.
  bool KeepsTopology(const Star& star, std::size_t m) const
  {
    const std::size_t count = star.Neighbors.size();
    const auto isNext = [&](std::size_t k) {
      return k + 1 == m || m + 1 == k || (!star.OnBoundary && (k + m + 1 == count) && (k == 0 || m == 0));
    };
    for (std::size_t k = 0; k < count; ++k)
    {
      if (k != m && !isNext(k) && this->HasEdge(star.Neighbors[k], star.Neighbors[m]))
      {
        return false;
      }
    }
    const bool isTetrahedron = !star.OnBoundary && count == 3 && this->HasTriangle(star.Neighbors);
    return !isTetrahedron;
  }

  /// Triangle k of the star stays a triangle when the vertex goes to neighbour @p m.
  static bool Stays(const Star& star, std::size_t k, std::size_t m)
  {
    return k != m && (k + 1) % star.Neighbors.size() != m;
  }

  /// Cost of the collapse to neighbour @p m; nothing when a triangle would turn over.
  std::optional<double> CostOf(
    Index v, const Star& star, const std::vector<Eigen::Vector2d>& plane, std::size_t m) const
  {
    const Index target = star.Neighbors[m];
    double worst = 1.0;
    double height = std::numeric_limits<double>::infinity();
    const Eigen::RowVector3d center = this->Points.row(v);
    Eigen::RowVector3d before = Eigen::RowVector3d::Zero();
    for (const Index f : star.Triangles)
    {
      const Corners& c = this->Triangles[f];
      const Eigen::RowVector3d a = this->Points.row(c[0]);
      before += (this->Points.row(c[1]) - a).cross(this->Points.row(c[2]) - a);
    }
    for (std::size_t k = 0; k < star.Triangles.size(); ++k)
    {
      if (Stays(star, k, m))
      {
        const std::size_t next = (k + 1) % star.Neighbors.size();
        if (PlaneShape(plane[m], plane[k], plane[next]) < LeastPlaneShape)
        {
          return std::nullopt;
        }
        const Eigen::RowVector3d a = this->Points.row(target);
        const Eigen::RowVector3d b = this->Points.row(star.Neighbors[k]);
        const Eigen::RowVector3d c = this->Points.row(star.Neighbors[next]);
        const bool turns = (b - a).cross(c - a).dot(before) <= 0.0;
        worst = std::min(worst, turns ? 0.0 : SpaceShape(a, b, c));
        height = std::min(height, DistanceToTriangle(center, a, b, c));
      }
    }
    const double length = (center - this->Points.row(target)).norm() + HeightWeight * height;
    const std::size_t after = this->TrianglesAround[target].size() + star.Triangles.size() - 4;
    const double crowd = after > MostTrianglesAfter ? static_cast<double>(after - MostTrianglesAfter) : 0.0;
    return length * (1.0 + crowd) / std::max(worst, LeastShape);
  }

  /// Puts the best collapse of @p v into the queue.
  void Consider(Index v)
  {
    const std::int64_t version = ++this->Version[v];
    const Star star = this->StarOf(v);
    const std::size_t least = star.OnBoundary ? 2 : 3;
    if (star.Triangles.size() < least || star.Triangles.size() > MostTrianglesAround)
    {
      return;
    }
    const std::vector<Eigen::Vector2d> plane = this->LayOut(v, star);
    Candidate best{ std::numeric_limits<double>::infinity(), v, -1, version };
    for (std::size_t m = 0; m < star.Neighbors.size(); ++m)
    {
      const bool allowed = !star.OnBoundary || m == 0 || m + 1 == star.Neighbors.size();
      const std::optional<double> cost = allowed && this->KeepsTopology(star, m) ? this->CostOf(v, star, plane, m)
                                                                                 : std::nullopt;
      if (cost && *cost < best.Cost)
      {
        best.Cost = *cost;
        best.Target = star.Neighbors[m];
      }
    }
    if (best.Target >= 0)
    {
      this->Queue.push(best);
    }
  }

  void Remove(Index v, const Star& star, std::size_t m)
  {
    const Index target = star.Neighbors[m];
    this->Collapses.push_back(this->CollapseOf(v, star, m));
    for (std::size_t k = 0; k < star.Triangles.size(); ++k)
    {
      const Index f = star.Triangles[k];
      if (Stays(star, k, m))
      {
        std::replace(this->Triangles[f].begin(), this->Triangles[f].end(), v, target);
        this->TrianglesAround[target].push_back(f);
      }
      else
      {
        for (const Index corner : this->Triangles[f])
        {
          auto& around = this->TrianglesAround[corner];
          around.erase(std::remove(around.begin(), around.end(), f), around.end());
        }
        this->Triangles[f] = { -1, -1, -1 };
        --this->Left;
      }
    }
    this->TrianglesAround[v].clear();
    ++this->Version[v];
    for (const Index neighbor : star.Neighbors)
    {
      this->Consider(neighbor);
    }
  }

  /// The triangles around @p v in the plane, before and after it goes to neighbour @p m.
  Collapse CollapseOf(Index v, const Star& star, std::size_t m) const
  {
    Collapse collapse;
    collapse.Points = this->LayOut(v, star);
    const auto center = static_cast<std::uint8_t>(star.Neighbors.size());
    for (std::size_t k = 0; k < star.Triangles.size(); ++k)
    {
      const Index f = star.Triangles[k];
      const auto at = static_cast<std::size_t>(
        std::find(this->Triangles[f].begin(), this->Triangles[f].end(), v) - this->Triangles[f].begin());
      Piece piece{ f, {} };
      piece.Corners[at] = center;
      piece.Corners[(at + 1) % 3] = static_cast<std::uint8_t>(k);
      piece.Corners[(at + 2) % 3] = static_cast<std::uint8_t>((k + 1) % star.Neighbors.size());
      collapse.Before.push_back(piece);
      if (Stays(star, k, m))
      {
        piece.Corners[at] = static_cast<std::uint8_t>(m);
        collapse.After.push_back(piece);
      }
    }
    return collapse;
  }

  /// Fills Result with the triangles that are left.
  void Collect()
  {
    std::vector<Index> id(this->TrianglesAround.size(), -1);
    for (std::size_t v = 0; v < id.size(); ++v)
    {
      if (!this->TrianglesAround[v].empty())
      {
        id[v] = static_cast<Index>(this->OriginalOfPoint.size());
        this->OriginalOfPoint.push_back(static_cast<Index>(v));
      }
    }
    this->Result.Points = this->Points(this->OriginalOfPoint, Eigen::all);
    this->Result.Triangles.resize(this->Left, 3);
    for (std::size_t f = 0; f < this->Triangles.size(); ++f)
    {
      if (this->Triangles[f][0] >= 0)
      {
        const auto row = static_cast<Index>(this->OriginalOf.size());
        for (int k = 0; k < 3; ++k)
        {
          this->Result.Triangles(row, k) = id[this->Triangles[f][k]];
        }
        this->OriginalOf.push_back(static_cast<Index>(f));
      }
    }
  }

  PointMatrix Points;
  std::vector<Corners> Triangles; ///< -1 when gone
  std::vector<std::vector<Index>> TrianglesAround;
  std::vector<std::int64_t> Version; ///< of the candidate of each vertex
  std::priority_queue<Candidate> Queue;
  std::vector<Collapse> Collapses;
  Index Left;
};

SurfaceSimplification::SurfaceSimplification(const TriangleMesh& mesh, Index triangles, const Progress& progress)
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = requirements.ConsistentWinding = true;
  RequireValidMesh(mesh, requirements);
  this->Impl = std::make_unique<Internals>(mesh);
  this->Impl->Simplify(triangles, progress);
}

SurfaceSimplification::~SurfaceSimplification() = default;

const TriangleMesh& SurfaceSimplification::Coarse() const { return this->Impl->Result; }

const std::vector<Index>& SurfaceSimplification::PointsOnInput() const { return this->Impl->OriginalOfPoint; }

std::vector<SurfacePlace> SurfaceSimplification::OnInput(const std::vector<SurfacePlace>& places) const
{
  for (const SurfacePlace& place : places)
  {
    if (place.Triangle < 0 || place.Triangle >= this->Coarse().NumberOfTriangles())
    {
      throw InvalidInput("SurfaceSimplification: a place names triangle " + std::to_string(place.Triangle) +
        "; expected 0 to " + std::to_string(this->Coarse().NumberOfTriangles() - 1) + ".");
    }
  }
  return this->Impl->Undo(places);
}

} // namespace surfsynth
