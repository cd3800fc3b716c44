// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SurfaceRelaxation.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/TriangleTree.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::int64_t Grain = 256;
constexpr double LeastFoldCosine = -0.5;

/// The edges of the boundary as triangles that use their second point twice.
TriangleMesh BoundaryOf(const TriangleMesh& mesh, const MeshTopology& topology)
{
  std::vector<Index> ends;
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      if (topology.EdgeTriangles[k] == 1 && v < topology.Neighbors[k])
      {
        ends.insert(ends.end(), { v, topology.Neighbors[k], topology.Neighbors[k] });
      }
    }
  }
  TriangleMesh boundary{ mesh.Points, {} };
  boundary.Triangles = Eigen::Map<const TriangleMatrix>(ends.data(), static_cast<Index>(ends.size()) / 3, 3);
  return boundary;
}

NearestPlace NearestIn(const TriangleTree& tree, const Eigen::RowVector3d& point)
{
  NearestPlace nearest;
  tree.FindIn(0, point.transpose(), nearest);
  return nearest;
}

/// The direction of the normal of a point.
Eigen::RowVector3d PointNormal(const TriangleMesh& mesh, const MeshTopology& topology, Index v)
{
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
  {
    sum += AreaVector(mesh, topology.VertexTriangles[k]).transpose();
  }
  return sum;
}

std::vector<Index> OneGroup(const TriangleMesh& mesh)
{
  return std::vector<Index>(static_cast<std::size_t>(mesh.NumberOfTriangles()), 0);
}

/// The mean of the neighbors of a point along the boundary.
Eigen::RowVector3d BoundaryMean(const TriangleMesh& mesh, const MeshTopology& topology, Index v)
{
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double count = 0.0;
  for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
  {
    if (topology.EdgeTriangles[k] == 1)
    {
      sum += mesh.Points.row(topology.Neighbors[k]);
      count += 1.0;
    }
  }
  return sum / count;
}

/// The mean of the centers of the triangles around a point, weighted by area; the point itself without area.
Eigen::RowVector3d AreaMean(const TriangleMesh& mesh, const MeshTopology& topology, Index v)
{
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double weight = 0.0;
  for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
  {
    const auto corners = mesh.Triangles.row(topology.VertexTriangles[k]);
    const Eigen::RowVector3d a = mesh.Points.row(corners[0]);
    const Eigen::RowVector3d b = mesh.Points.row(corners[1]);
    const Eigen::RowVector3d c = mesh.Points.row(corners[2]);
    const double area = (b - a).cross(c - a).norm();
    sum += area / 3.0 * (a + b + c);
    weight += area;
  }
  return weight > 0.0 ? Eigen::RowVector3d(sum / weight) : Eigen::RowVector3d(mesh.Points.row(v));
}

/// The mean of the neighbors of a point.
Eigen::RowVector3d NeighborMean(const TriangleMesh& mesh, const MeshTopology& topology, Index v)
{
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
  {
    sum += mesh.Points.row(topology.Neighbors[k]);
  }
  return sum / (topology.NeighborStart[v + 1] - topology.NeighborStart[v]);
}

/// Triangles whose normals differ by more than 120 degrees from those of a neighbor.
std::vector<Index> FoldedTriangles(const TriangleMesh& mesh, const MeshTopology& topology)
{
  PointMatrix normals(mesh.NumberOfTriangles(), 3);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    normals.row(f) = AreaVector(mesh, f).stableNormalized().transpose();
  }
  const auto isFolded = [&](Index f) {
    for (int k = 0; k < 3; ++k)
    {
      const Index a = mesh.Triangles(f, k);
      const Index b = mesh.Triangles(f, (k + 1) % 3);
      for (Index i = topology.VertexTriangleStart[a]; i < topology.VertexTriangleStart[a + 1]; ++i)
      {
        const Index g = topology.VertexTriangles[i];
        const bool isNeighbor = g != f && (mesh.Triangles.row(g).array() == b).any();
        if (isNeighbor && normals.row(f).dot(normals.row(g)) < LeastFoldCosine)
        {
          return true;
        }
      }
    }
    return false;
  };
  std::vector<Index> folded;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (isFolded(f))
    {
      folded.push_back(f);
    }
  }
  return folded;
}

/// The corners of the triangles and their neighbors.
std::vector<char> PointsNear(
  const TriangleMesh& mesh, const MeshTopology& topology, const std::vector<Index>& triangles)
{
  std::vector<char> near(static_cast<std::size_t>(topology.NumberOfPoints()), 0);
  for (const Index f : triangles)
  {
    for (const Index v : mesh.Triangles.row(f))
    {
      near[v] = 1;
      for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
      {
        near[topology.Neighbors[k]] = 1;
      }
    }
  }
  return near;
}

/// Applies @p place to each point, with the boundary flag of it.
template <typename Place>
PointMatrix PlaceAll(const MeshTopology& topology, const Place& place)
{
  PointMatrix points(topology.NumberOfPoints(), 3);
  ParallelFor(topology.NumberOfPoints(), Grain, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<Index>(begin); v < static_cast<Index>(end); ++v)
    {
      points.row(v) = place(v, topology.IsOnBoundary(v));
    }
  });
  return points;
}
} // namespace

class NearestSurface::Internals
{
public:
  explicit Internals(const TriangleMesh& surface)
    : Boundary(BoundaryOf(surface, MeshTopology(surface)))
    , Surface(surface)
    , Tree(surface, OneGroup(surface))
  {
    if (this->Boundary.NumberOfTriangles() > 0)
    {
      this->BoundaryTree.emplace(this->Boundary, OneGroup(this->Boundary));
    }
  }
  TriangleMesh Boundary;
  const TriangleMesh& Surface;
  TriangleTree Tree;
  std::optional<TriangleTree> BoundaryTree;
};

NearestSurface::NearestSurface(const TriangleMesh& surface)
  : Impl(std::make_unique<Internals>(surface))
{}

NearestSurface::~NearestSurface() = default;

std::optional<Eigen::RowVector3d> NearestSurface::Nearest(
  const Eigen::RowVector3d& point, const Eigen::RowVector3d& normal) const
{
  const NearestPlace nearest = NearestIn(this->Impl->Tree, point);
  const bool agrees = AreaVector(this->Impl->Surface, nearest.Place.Triangle).dot(normal.transpose()) >= 0.0;
  return agrees ? std::optional<Eigen::RowVector3d>(nearest.Position.transpose()) : std::nullopt;
}

std::vector<SurfacePlace> NearestSurface::NearestPlaces(const PointMatrix& points) const
{
  std::vector<SurfacePlace> places(static_cast<std::size_t>(points.rows()));
  ParallelFor(points.rows(), Grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      places[static_cast<std::size_t>(k)] = NearestIn(this->Impl->Tree, points.row(k)).Place;
    }
  });
  return places;
}

Eigen::RowVector3d NearestSurface::NearestOnBoundary(const Eigen::RowVector3d& point) const
{
  return this->Impl->BoundaryTree ? Eigen::RowVector3d(NearestIn(*this->Impl->BoundaryTree, point).Position.transpose())
                                  : point;
}

void RelaxOnSurface(
  TriangleMesh& mesh, const MeshTopology& topology, const NearestSurface& surface, int rounds, const Progress& progress)
{
  for (int round = 0; round < rounds; ++round)
  {
    Report(progress, static_cast<double>(round) / rounds);
    mesh.Points = PlaceAll(topology, [&](Index v, bool onBoundary) -> Eigen::RowVector3d {
      const Eigen::RowVector3d mean = onBoundary ? BoundaryMean(mesh, topology, v) : AreaMean(mesh, topology, v);
      const Eigen::RowVector3d point = 0.5 * (mesh.Points.row(v) + mean);
      return onBoundary ? surface.NearestOnBoundary(point)
                        : surface.Nearest(point, PointNormal(mesh, topology, v)).value_or(mesh.Points.row(v));
    });
  }
}

std::int64_t SmoothFolds(TriangleMesh& mesh, const MeshTopology& topology, int rounds)
{
  std::vector<Index> folded = FoldedTriangles(mesh, topology);
  for (int round = 0; round < rounds && !folded.empty(); ++round)
  {
    const std::vector<char> moves = PointsNear(mesh, topology, folded);
    mesh.Points = PlaceAll(topology, [&](Index v, bool onBoundary) -> Eigen::RowVector3d {
      const Eigen::RowVector3d point = mesh.Points.row(v);
      return onBoundary || !moves[v] ? point : Eigen::RowVector3d(0.5 * (point + NeighborMean(mesh, topology, v)));
    });
    folded = FoldedTriangles(mesh, topology);
  }
  return static_cast<std::int64_t>(folded.size());
}

} // namespace surfsynth
