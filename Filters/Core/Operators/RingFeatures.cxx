// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Operators/RingFeatures.h"

#include "Core/Common/Parallel.h"
#include "Core/Common/Quantiles.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::int64_t VertexGrain = 4096;
constexpr std::int64_t VerticesOfTask = 512;

/// Sum of the area vectors of the triangles around each vertex, [V, 3].
PointMatrix AreaVectors(const TriangleMesh& mesh, const MeshTopology& topology)
{
  PointMatrix vectors = PointMatrix::Zero(mesh.Points.rows(), 3);
  ParallelFor(mesh.Points.rows(), VertexGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
      {
        vectors.row(v) += 0.5 * AreaVector(mesh, topology.VertexTriangles[k]).transpose();
      }
    }
  });
  return vectors;
}

/// Rings around one vertex, and the memory to find them.
struct Neighborhood
{
  std::vector<Index> CenterOf;    ///< [V], center of the last neighborhood that each vertex was found in
  std::vector<Index> Vertices;    ///< ring after ring, from the center on
  std::vector<std::size_t> Start; ///< [R + 2], ring j is Vertices[Start[j] .. Start[j + 1])
  std::vector<double> Heights;

  void Find(const MeshTopology& topology, Index center, int rings)
  {
    this->CenterOf.resize(static_cast<std::size_t>(topology.NumberOfPoints()), -1);
    this->Vertices.assign(1, center);
    this->Start.assign({ 0, 1 });
    this->CenterOf[center] = center;
    for (int ring = 1; ring <= rings; ++ring)
    {
      for (std::size_t k = this->Start[ring - 1]; k < this->Start[ring]; ++k)
      {
        this->AddNeighbors(topology, this->Vertices[k]);
      }
      this->Start.push_back(this->Vertices.size());
    }
  }

private:
  void AddNeighbors(const MeshTopology& topology, Index v)
  {
    const Index center = this->Vertices.front();
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      const Index w = topology.Neighbors[k];
      if (this->CenterOf[w] != center)
      {
        this->CenterOf[w] = center;
        this->Vertices.push_back(w);
      }
    }
  }
};

/// What the features of a mesh are made of.
struct RingFeatureMaker
{
  const TriangleMesh& Mesh;
  const MeshTopology& Topology;
  int Rings;
  PointMatrix Areas;
  std::vector<std::uint8_t> Boundary; ///< [V], 1 for vertices on a boundary

  /// Fills the 6 R features of vertex @p v. @return true when its rings are whole
  bool Fill(Index v, Neighborhood& near, float* out) const
  {
    near.Find(this->Topology, v, this->Rings);
    bool whole = true;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (std::size_t k = 0; k < near.Vertices.size(); ++k)
    {
      sum += this->Areas.row(near.Vertices[k]);
      whole = whole && (k >= near.Start[this->Rings] || !this->Boundary[near.Vertices[k]]);
    }
    const double length = sum.stableNorm();
    const Eigen::RowVector3d normal = length > 0.0 ? Eigen::RowVector3d(sum / length) : Eigen::RowVector3d::Zero();
    for (int ring = 1; ring <= this->Rings; ++ring)
    {
      float* features = out + static_cast<std::size_t>(FeaturesOfRing) * (ring - 1);
      if (near.Start[ring] == near.Start[ring + 1])
      {
        std::copy_n(features - FeaturesOfRing, FeaturesOfRing, features);
        continue;
      }
      this->FillRing(v, normal, near, ring, features);
    }
    return whole;
  }

private:
  void FillRing(Index v, const Eigen::RowVector3d& normal, Neighborhood& near, int ring, float* out) const
  {
    double distances = 0.0;
    near.Heights.clear();
    for (std::size_t k = near.Start[ring]; k < near.Start[ring + 1]; ++k)
    {
      const Eigen::RowVector3d offset = this->Mesh.Points.row(near.Vertices[k]) - this->Mesh.Points.row(v);
      near.Heights.push_back(offset.dot(normal));
      distances += (offset - near.Heights.back() * normal).norm();
    }
    if (!std::isfinite(distances)) // numbers that are not finite have no order
    {
      std::fill_n(out, FeaturesOfRing, std::numeric_limits<float>::quiet_NaN());
      return;
    }
    std::sort(near.Heights.begin(), near.Heights.end());
    for (int quarter = 0; quarter <= 4; ++quarter)
    {
      out[quarter] = static_cast<float>(
        QuantileOfSorted(near.Heights.data(), static_cast<Eigen::Index>(near.Heights.size()), 0.25 * quarter));
    }
    out[5] = static_cast<float>(distances / static_cast<double>(near.Heights.size()));
  }
};

/// The rows that @p wanted says, or, when there are none, those that @p others says.
RingFeatureMatrix RowsOf(
  const RingFeatureMatrix& all, const std::vector<std::uint8_t>& wanted, const std::vector<std::uint8_t>& others)
{
  const bool some = std::find(wanted.begin(), wanted.end(), 1) != wanted.end();
  const std::vector<std::uint8_t>& kept = some ? wanted : others;
  RingFeatureMatrix rows(std::count(kept.begin(), kept.end(), 1), all.cols());
  Eigen::Index next = 0;
  for (std::size_t v = 0; v < kept.size(); ++v)
  {
    if (kept[v])
    {
      rows.row(next++) = all.row(static_cast<Eigen::Index>(v));
    }
  }
  return rows;
}
} // namespace

RingFeatureMatrix ComputeRingFeatures(
  const TriangleMesh& mesh, const MeshTopology& topology, int rings, const Progress& progress)
{
  const Index count = mesh.NumberOfPoints();
  RingFeatureMaker maker{ mesh, topology, rings, AreaVectors(mesh, topology), {} };
  for (Index v = 0; v < count; ++v)
  {
    maker.Boundary.push_back(topology.IsOnBoundary(v) ? 1 : 0);
  }
  RingFeatureMatrix features(count, FeaturesOfRing * static_cast<Eigen::Index>(rings));
  std::vector<std::uint8_t> whole(static_cast<std::size_t>(count), 0), used(static_cast<std::size_t>(count), 0);
  ScratchPool<Neighborhood> pool;
  const std::int64_t tasks = (count + VerticesOfTask - 1) / VerticesOfTask;
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    tasks,
    [&](std::int64_t task) {
      Neighborhood near = pool.Borrow();
      const std::int64_t end = std::min<std::int64_t>(count, (task + 1) * VerticesOfTask);
      for (auto v = static_cast<Index>(task * VerticesOfTask); v < end; ++v)
      {
        used[v] = topology.NeighborStart[v] < topology.NeighborStart[v + 1] ? 1 : 0;
        whole[v] = used[v] && maker.Fill(v, near, features.row(v).data()) ? 1 : 0;
      }
      pool.Return(std::move(near));
      ++done;
    },
    [&] { Report(progress, static_cast<double>(done) / static_cast<double>(tasks)); });
  return RowsOf(features, whole, used);
}

} // namespace surfsynth
