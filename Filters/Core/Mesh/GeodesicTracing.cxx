// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/GeodesicTracing.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace surfsynth
{

namespace
{
/// Third component of the cross product.
double CrossProduct(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Side of triangle @p f that runs from point @p start to point @p end; -1 for none.
int SideBetween(const TriangleMesh& mesh, Index f, Index start, Index end)
{
  for (int k = 0; k < 3; ++k)
  {
    if (mesh.Triangles(f, k) == start && mesh.Triangles(f, (k + 1) % 3) == end)
    {
      return k;
    }
  }
  return -1;
}
} // namespace

/// A geodesic on its way: in the plane that its triangle is laid into.
struct GeodesicTracer::Ray
{
  Index Triangle;
  int From = -1; ///< side that it came in by; -1 in its first triangle
  Eigen::Vector2d Point;
  Eigen::Vector2d Direction;
};

GeodesicTracer::GeodesicTracer(const TriangleMesh& mesh, const TriangleAdjacency& adjacency)
  : Mesh(mesh)
  , Normals(mesh.NumberOfTriangles(), 3)
  , Layouts(static_cast<std::size_t>(mesh.NumberOfTriangles()))
{
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto f = static_cast<Index>(begin); f < end; ++f)
    {
      this->Normals.row(f) = AreaVector(mesh, f).normalized().transpose();
      this->LayOut(f, adjacency);
    }
  });
}

Eigen::Matrix<double, 3, 2> GeodesicTracer::Axes(Index f) const
{
  const auto corners = this->Mesh.Triangles.row(f);
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = (this->Mesh.Points.row(corners(1)) - this->Mesh.Points.row(corners(0))).normalized().transpose();
  axes.col(1) = this->Normal(f).cross(axes.col(0));
  return axes;
}

void GeodesicTracer::LayOut(Index f, const TriangleAdjacency& adjacency)
{
  const auto corners = this->Mesh.Triangles.row(f);
  const Eigen::Matrix<double, 3, 2> axes = this->Axes(f);
  Layout& layout = this->Layouts[static_cast<std::size_t>(f)];
  for (int k = 0; k < 3; ++k)
  {
    layout.Corners[k] = ((this->Mesh.Points.row(corners(k)) - this->Mesh.Points.row(corners(0))) * axes).transpose();
  }
  for (int k = 0; k < 3; ++k)
  {
    layout.Edges[k] = (layout.Corners[(k + 1) % 3] - layout.Corners[k]).normalized();
    const Index other = adjacency.Across(f, k);
    const int side = other < 0 ? -1 : SideBetween(this->Mesh, other, corners((k + 1) % 3), corners(k));
    layout.Across[k] = side < 0 ? TriangleAdjacency::Boundary : other;
    layout.Sides[k] = static_cast<std::int8_t>(side);
  }
}

/// Returns the side through which a ray leaves its triangle, and the distance to it; -1 for none.
int GeodesicTracer::NextSide(const Ray& ray, double& distance) const
{
  const Layout& layout = this->LayoutOf(ray.Triangle);
  int next = -1;
  distance = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 3; ++side)
  {
    const double slope = CrossProduct(layout.Edges[side], ray.Direction); // below 0 outwards
    if (side != ray.From && slope < 0.0)
    {
      const double reached = std::max(0.0, CrossProduct(layout.Edges[side], layout.Corners[side] - ray.Point) / slope);
      if (reached < distance)
      {
        distance = reached;
        next = side;
      }
    }
  }
  return next;
}

/// Takes a ray across a side, whose triangles are laid into one plane; returns false at a boundary.
bool GeodesicTracer::Cross(Ray& ray, int side) const
{
  const Layout& layout = this->LayoutOf(ray.Triangle);
  const Index other = layout.Across[side];
  if (other < 0)
  {
    return false;
  }
  const Eigen::Vector2d& edge = layout.Edges[side];
  const double passed = edge.dot(ray.Point - layout.Corners[side]);
  const double along = edge.dot(ray.Direction);
  const double across = CrossProduct(edge, ray.Direction);
  ray.Triangle = other;
  ray.From = layout.Sides[side];
  // There the edge runs the other way.
  const Layout& next = this->LayoutOf(other);
  const Eigen::Vector2d& back = next.Edges[ray.From];
  ray.Point = next.Corners[(ray.From + 1) % 3] - passed * back;
  ray.Direction = -along * back - across * Eigen::Vector2d(-back.y(), back.x());
  return true;
}

/// Returns the end of a geodesic that has come so far.
GeodesicEnd GeodesicTracer::EndOf(const Ray& ray, bool isComplete) const
{
  const auto& [a, b, c] = this->LayoutOf(ray.Triangle).Corners;
  const Eigen::Vector2d& point = ray.Point;
  Eigen::Vector3d weights(
    CrossProduct(c - b, point - b), CrossProduct(a - c, point - c), CrossProduct(b - a, point - a));
  weights = weights.cwiseMax(0.0);
  const double sum = weights.sum();
  weights = sum > 0.0 ? Eigen::Vector3d(weights / sum) : Eigen::Vector3d::Constant(1.0 / 3.0);
  return { { ray.Triangle, weights }, (this->Axes(ray.Triangle) * ray.Direction).normalized(), isComplete };
}

GeodesicEnd GeodesicTracer::Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, double length) const
{
  GeodesicEnd end;
  this->Trace(start, direction, 1, &length, &end);
  return end;
}

void GeodesicTracer::Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, int count,
  const double* lengths, GeodesicEnd* ends) const
{
  const Layout& layout = this->LayoutOf(start.Triangle);
  Ray ray{ start.Triangle, -1, start.Weights(1) * layout.Corners[1] + start.Weights(2) * layout.Corners[2],
    this->Axes(start.Triangle).transpose() * direction };
  double passed = 0.0;
  int done = 0;
  for (int crossing = 0; crossing < MostCrossings && done < count; ++crossing)
  {
    double distance = 0.0;
    const int side = this->NextSide(ray, distance);
    for (; side >= 0 && done < count && lengths[done] <= passed + distance; ++done)
    {
      Ray last = ray;
      last.Point += (lengths[done] - passed) * ray.Direction;
      ends[done] = this->EndOf(last, true);
    }
    if (side < 0 || done == count)
    {
      break;
    }
    ray.Point += distance * ray.Direction;
    passed += distance;
    if (!this->Cross(ray, side))
    {
      break;
    }
  }
  for (; done < count; ++done)
  {
    ends[done] = this->EndOf(ray, false);
  }
}

} // namespace surfsynth
