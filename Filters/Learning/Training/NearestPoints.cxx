// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/NearestPoints.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/PointCloud.h"

#include <Eigen/Geometry>
#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr std::int64_t QueryGrain = 256;
using Point = Eigen::RowVector3d;

using Tree =
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>, PointCloud, 3, std::uint32_t>;

double DistanceToSegment(const Point& p, const Point& a, const Point& b)
{
  const Point edge = b - a;
  const double length = edge.squaredNorm();
  const double t = length > 0.0 ? std::clamp((p - a).dot(edge) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * edge).norm();
}

double DistanceToTriangle(const Point& p, const Point& a, const Point& b, const Point& c)
{
  const Point normal = (b - a).cross(c - a);
  const double area = normal.norm();
  // Above the triangle when it lies to the left of each edge.
  const bool above = area > 0.0 && (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
    (a - c).cross(p - c).dot(normal) >= 0.0;
  if (above)
  {
    return std::abs((p - a).dot(normal)) / area;
  }
  return std::min({ DistanceToSegment(p, a, b), DistanceToSegment(p, b, c), DistanceToSegment(p, c, a) });
}

/// Triangles by their centroids. No point of a triangle is farther than Radius from its centroid.
struct CentroidTree
{
  explicit CentroidTree(const TriangleMesh& surface)
    : Surface(surface)
    , Centroids(surface.Triangles.rows(), 3)
  {
    for (Eigen::Index f = 0; f < surface.Triangles.rows(); ++f)
    {
      const auto corner = [&](int k) -> Point { return surface.Points.row(surface.Triangles(f, k)); };
      const Point centroid = (corner(0) + corner(1) + corner(2)) / 3.0;
      this->Centroids.row(f) = centroid;
      for (int k = 0; k < 3; ++k)
      {
        this->Radius = std::max(this->Radius, (corner(k) - centroid).norm());
      }
    }
    this->Centers = std::make_unique<PointTree>(this->Centroids);
  }

  /// Looks at triangles in the order of their centroids, until no other one can be nearer.
  double Distance(const Point& query) const
  {
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t seen = 0;
    for (std::size_t count = 8;; count *= 2)
    {
      const std::vector<std::uint32_t> ids = this->Centers->Nearest(query, count);
      for (; seen < ids.size(); ++seen)
      {
        if ((query - this->Centroids.row(ids[seen])).norm() - this->Radius > nearest)
        {
          return nearest;
        }
        const auto corner = [&](int k) -> Point {
          return this->Surface.Points.row(this->Surface.Triangles(ids[seen], k));
        };
        nearest = std::min(nearest, DistanceToTriangle(query, corner(0), corner(1), corner(2)));
      }
      if (ids.size() < count)
      {
        return nearest;
      }
    }
  }

  const TriangleMesh& Surface;
  PointMatrix Centroids;
  double Radius = 0.0;
  std::unique_ptr<PointTree> Centers;
};
} // namespace

class PointTree::Internals
{
public:
  explicit Internals(const PointMatrix& points)
    : Cloud{ points }
    , Index(3, this->Cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10))
  {
    this->Index.buildIndex();
  }
  PointCloud Cloud;
  Tree Index;
};

PointTree::PointTree(const PointMatrix& points)
  : Impl(std::make_unique<Internals>(points))
{}

PointTree::~PointTree() = default;

std::vector<std::int64_t> PointTree::Nearest(const PointMatrix& queries) const
{
  std::vector<std::int64_t> nearest(static_cast<std::size_t>(queries.rows()));
  ParallelFor(queries.rows(), QueryGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      std::uint32_t id = 0;
      double squared = 0.0;
      this->Impl->Index.knnSearch(queries.row(k).data(), 1, &id, &squared);
      nearest[static_cast<std::size_t>(k)] = id;
    }
  });
  return nearest;
}

std::vector<std::uint32_t> PointTree::Nearest(const Eigen::RowVector3d& query, std::size_t count) const
{
  std::vector<std::uint32_t> ids(count);
  std::vector<double> squared(count);
  ids.resize(this->Impl->Index.knnSearch(query.data(), count, ids.data(), squared.data()));
  return ids;
}

PointDistances DistanceToSurface(const PointMatrix& queries, const TriangleMesh& surface)
{
  const CentroidTree tree(surface);
  Eigen::VectorXd distances(queries.rows());
  ParallelFor(queries.rows(), QueryGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      distances[k] = tree.Distance(queries.row(k));
    }
  });
  return { distances.mean(), distances.maxCoeff() };
}

} // namespace surfsynth
