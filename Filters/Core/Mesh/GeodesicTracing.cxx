// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/GeodesicTracing.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace surfsynth
{

/// A geodesic on its way.
struct GeodesicTracer::Ray
{
  Index Triangle;
  int From = -1; ///< side that it came in by; -1 in its first triangle
  Eigen::Vector3d Point;
  Eigen::Vector3d Direction;
};

GeodesicTracer::GeodesicTracer(const TriangleMesh& mesh, const TriangleAdjacency& adjacency)
  : Mesh(mesh)
  , Adjacency(adjacency)
  , Normals(mesh.NumberOfTriangles(), 3)
{
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      this->Normals.row(f) = AreaVector(mesh, static_cast<Index>(f)).normalized().transpose();
    }
  });
}

/// Returns the side through which a ray leaves its triangle, and the distance to it; -1 for none.
int GeodesicTracer::NextSide(const Ray& ray, double& distance) const
{
  const auto corners = this->Mesh.Triangles.row(ray.Triangle);
  const Eigen::Vector3d normal = this->Normal(ray.Triangle);
  int next = -1;
  distance = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 3; ++side)
  {
    if (side == ray.From)
    {
      continue;
    }
    const Eigen::Vector3d start = this->Mesh.Points.row(corners(side)).transpose();
    const Eigen::Vector3d edge = this->Mesh.Points.row(corners((side + 1) % 3)).transpose() - start;
    const Eigen::Vector3d inwards = normal.cross(edge);
    const double slope = ray.Direction.dot(inwards);
    if (slope < 0.0)
    {
      const double reached = std::max(0.0, (start - ray.Point).dot(inwards) / slope);
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
  const Index other = this->Adjacency.Across(ray.Triangle, side);
  if (other < 0)
  {
    return false;
  }
  const Index start = this->Mesh.Triangles(ray.Triangle, side);
  const Index end = this->Mesh.Triangles(ray.Triangle, (side + 1) % 3);
  const Eigen::Vector3d edge = (this->Mesh.Points.row(end) - this->Mesh.Points.row(start)).transpose().normalized();
  const double along = ray.Direction.dot(edge);
  const double across = ray.Direction.dot(this->Normal(ray.Triangle).cross(edge));
  ray.Direction = (along * edge + across * this->Normal(other).cross(edge)).normalized();
  ray.Triangle = other;
  for (int k = 0; k < 3; ++k)
  {
    if (this->Mesh.Triangles(other, k) == end && this->Mesh.Triangles(other, (k + 1) % 3) == start)
    {
      ray.From = k;
    }
  }
  return true;
}

Eigen::Vector3d GeodesicTracer::Weights(const Ray& ray) const
{
  const auto corners = this->Mesh.Triangles.row(ray.Triangle);
  const Eigen::Vector3d a = this->Mesh.Points.row(corners(0)).transpose();
  const Eigen::Vector3d b = this->Mesh.Points.row(corners(1)).transpose();
  const Eigen::Vector3d c = this->Mesh.Points.row(corners(2)).transpose();
  const Eigen::Vector3d normal = this->Normal(ray.Triangle);
  Eigen::Vector3d weights((c - b).cross(ray.Point - b).dot(normal), (a - c).cross(ray.Point - c).dot(normal),
    (b - a).cross(ray.Point - a).dot(normal));
  weights = weights.cwiseMax(0.0);
  const double sum = weights.sum();
  return sum > 0.0 ? Eigen::Vector3d(weights / sum) : Eigen::Vector3d::Constant(1.0 / 3.0);
}

GeodesicEnd GeodesicTracer::Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, double length) const
{
  Ray ray{ start.Triangle, -1, PositionOf(this->Mesh, start), direction };
  double left = length;
  bool isComplete = false;
  for (int crossing = 0; crossing < MostCrossings; ++crossing)
  {
    double distance = 0.0;
    const int side = this->NextSide(ray, distance);
    if (side < 0 || distance >= left)
    {
      isComplete = side >= 0;
      ray.Point += (isComplete ? left : 0.0) * ray.Direction;
      break;
    }
    ray.Point += distance * ray.Direction;
    left -= distance;
    if (!this->Cross(ray, side))
    {
      break;
    }
  }
  return { { ray.Triangle, this->Weights(ray) }, ray.Direction, isComplete };
}

} // namespace surfsynth
