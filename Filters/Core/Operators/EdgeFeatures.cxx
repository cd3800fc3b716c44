// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Operators/EdgeFeatures.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/TriangleAdjacency.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr std::int64_t EdgeGrain = 4096;

Eigen::RowVector3d UnitOrZero(const Eigen::RowVector3d& vector)
{
  const double length = vector.norm();
  return length > 0.0 ? Eigen::RowVector3d(vector / length) : Eigen::RowVector3d::Zero();
}

/// The edges of a triangle with their frames. In double: the normal of a needle is a small difference.
struct EdgeFrames
{
  EdgeFrames(const SinglePoints& points, const TriangleMatrix& triangles, std::int64_t f)
  {
    for (int k = 0; k < 3; ++k)
    {
      this->Corner[k] = points.row(triangles(f, k)).cast<double>();
    }
    for (int k = 0; k < 3; ++k)
    {
      this->Edge[k] = this->Corner[(k + 1) % 3] - this->Corner[k];
    }
    this->Normal = UnitOrZero(this->Edge[0].cross(this->Edge[1]));
  }
  Eigen::RowVector3d Along(int edge) const { return UnitOrZero(this->Edge[edge]); }
  /// Unit vector out of the triangle, across the edge.
  Eigen::RowVector3d Outward(const Eigen::RowVector3d& along) const { return along.cross(this->Normal); }

  Eigen::RowVector3d Corner[3];
  Eigen::RowVector3d Edge[3];
  Eigen::RowVector3d Normal;
};

/// The corner of @p triangle that is neither of the ends of an edge.
Index OppositeCorner(const TriangleMatrix& triangles, Index triangle, Index a, Index b)
{
  const Index* corners = triangles.data() + 3 * static_cast<std::size_t>(triangle);
  return *std::find_if(corners, corners + 3, [&](Index v) { return v != a && v != b; });
}
} // namespace

FaceNeighbors ComputeFaceNeighbors(const TriangleMesh& mesh) { return ComputeFaceNeighbors(mesh, MeshTopology(mesh)); }

FaceNeighbors ComputeFaceNeighbors(const TriangleMesh& mesh, const MeshTopology& topology)
{
  const TriangleAdjacency adjacency(mesh, topology);
  FaceNeighbors neighbors;
  neighbors.Faces.resize(mesh.NumberOfTriangles(), 3);
  neighbors.Opposite.resize(mesh.NumberOfTriangles(), 3);
  ParallelFor(mesh.NumberOfTriangles(), EdgeGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto f = static_cast<Index>(begin); f < end; ++f)
    {
      for (int edge = 0; edge < 3; ++edge)
      {
        const Index a = mesh.Triangles(f, edge);
        const Index b = mesh.Triangles(f, (edge + 1) % 3);
        const Index beyond = adjacency.Across(f, edge);
        if (beyond == TriangleAdjacency::Several)
        {
          throw InvalidInput("ComputeFaceNeighbors: the edge between the vertices " + std::to_string(a) + " and " +
            std::to_string(b) + " has three triangles or more; expected one or two.");
        }
        const Index neighbor = beyond == TriangleAdjacency::Boundary ? f : beyond;
        neighbors.Faces(f, edge) = neighbor;
        neighbors.Opposite(f, edge) = OppositeCorner(mesh.Triangles, neighbor, a, b);
      }
    }
  });
  return neighbors;
}

EdgeFeatureMatrix ComputeEdgeFeatures(
  const SinglePoints& points, const TriangleMatrix& triangles, const FaceNeighbors& neighbors)
{
  EdgeFeatureMatrix features(triangles.rows(), 12);
  ParallelFor(triangles.rows(), EdgeGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const EdgeFrames frames(points, triangles, f);
      for (int edge = 0; edge < 3; ++edge)
      {
        const Eigen::RowVector3d x = frames.Along(edge);
        const double side = neighbors.Faces(f, edge) == f ? -1.0 : 1.0; // half a turn beyond a boundary
        const Eigen::RowVector3d beyond = side *
          (points.row(neighbors.Opposite(f, edge)).cast<double>() -
            0.5 * (frames.Corner[edge] + frames.Corner[(edge + 1) % 3]));
        float* out = features.row(f).data() + 4 * edge;
        out[0] = static_cast<float>(beyond.dot(x));
        out[1] = static_cast<float>(beyond.dot(frames.Outward(x)));
        out[2] = static_cast<float>(beyond.dot(frames.Normal));
        out[3] = static_cast<float>(frames.Edge[edge].norm());
      }
    }
  });
  return features;
}

SinglePoints MeanCornerDisplacement(
  const SinglePoints& points, const TriangleMatrix& triangles, const Eigen::Ref<const SinglePoints>& local)
{
  using CornerMatrix = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;
  CornerMatrix corners(triangles.rows(), 9);
  ParallelFor(triangles.rows(), EdgeGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const EdgeFrames frames(points, triangles, f);
      const Eigen::RowVector3d abc = local.row(f).cast<double>();
      for (int k = 0; k < 3; ++k)
      {
        const Eigen::RowVector3d x = frames.Along(k);
        corners.block<1, 3>(f, 3 * k) = abc(0) * x + abc(1) * frames.Outward(x) + abc(2) * frames.Normal;
      }
    }
  });
  // Summed in the order of the triangles, so that the bits do not depend on the threads.
  PointMatrix sums = PointMatrix::Zero(points.rows(), 3);
  std::vector<Index> degree(static_cast<std::size_t>(points.rows()), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      sums.row(triangles(f, k)) += corners.block<1, 3>(f, 3 * k);
      ++degree[triangles(f, k)];
    }
  }
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    sums.row(v) /= std::max<double>(degree[v], 1.0);
  }
  return sums.cast<float>();
}

} // namespace surfsynth
