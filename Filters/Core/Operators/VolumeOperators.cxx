// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Operators/VolumeOperators.h"

#include "Core/Common/LargeArray.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace surfsynth
{

namespace
{
/// Number of the pair of corners i < j: 01, 02, 03, 12, 13, 23.
constexpr int PairOf[4][4] = { { -1, 0, 1, 2 }, { 0, -1, 3, 4 }, { 1, 3, -1, 5 }, { 2, 4, 5, -1 } };

Eigen::Matrix3d TensorOf(const VolumeTensors& tensors, Eigen::Index t)
{
  Eigen::Matrix3d tensor;
  tensor << tensors(t, 0), tensors(t, 1), tensors(t, 2), tensors(t, 1), tensors(t, 3), tensors(t, 4), tensors(t, 2),
    tensors(t, 4), tensors(t, 5);
  return tensor;
}

/// Entries of the element matrix of tetrahedron @p t for its six pairs of corners.
void FillPairs(const TetrahedralMesh& mesh, const VolumeTensors& tensors, Index t, double* pairs)
{
  const Eigen::Matrix3d edges = EdgesFromFirstCorner(mesh.Points, mesh.Tetrahedra, t);
  Eigen::Matrix<double, 3, 4> gradients; // times sixfold
  gradients.col(1) = edges.col(1).cross(edges.col(2));
  gradients.col(2) = edges.col(2).cross(edges.col(0));
  gradients.col(3) = edges.col(0).cross(edges.col(1));
  gradients.col(0) = -(gradients.col(1) + gradients.col(2) + gradients.col(3));
  const double sixfold = std::abs(edges.col(0).dot(gradients.col(1)));
  const Eigen::Matrix<double, 3, 4> flux = tensors.rows() > 0 ? (TensorOf(tensors, t) * gradients).eval() : gradients;
  for (int i = 0; i < 4; ++i)
  {
    for (int j = i + 1; j < 4; ++j)
    {
      pairs[PairOf[i][j]] = gradients.col(i).dot(flux.col(j)) / (6.0 * sixfold);
    }
  }
}

/// Corners at each vertex: places 4 t + k in the matrix of tetrahedra, ascending.
struct VertexCorners
{
  explicit VertexCorners(const TetrahedralMesh& mesh)
    : Start(static_cast<std::size_t>(mesh.NumberOfPoints()) + 1, 0)
    , Corners(static_cast<std::size_t>(mesh.Tetrahedra.size()))
  {
    const Index* ids = mesh.Tetrahedra.data();
    for (Eigen::Index k = 0; k < mesh.Tetrahedra.size(); ++k)
    {
      ++this->Start[static_cast<std::size_t>(ids[k]) + 1];
    }
    for (std::size_t v = 1; v < this->Start.size(); ++v)
    {
      this->Start[v] += this->Start[v - 1];
    }
    std::vector<std::int64_t> next(this->Start.begin(), this->Start.end() - 1);
    for (Eigen::Index k = 0; k < mesh.Tetrahedra.size(); ++k)
    {
      this->Corners[static_cast<std::size_t>(next[ids[k]]++)] = k;
    }
  }

  std::vector<std::int64_t> Start;   ///< [V + 1]
  std::vector<std::int64_t> Corners; ///< [4 T]
};

/// Vertex @p v and those joined to it, ascending.
void FindColumn(const TetrahedralMesh& mesh, const VertexCorners& corners, Index v, std::vector<Index>& column)
{
  column.assign(1, v);
  for (std::int64_t k = corners.Start[v]; k < corners.Start[static_cast<std::size_t>(v) + 1]; ++k)
  {
    const Index* ids = mesh.Tetrahedra.data() + corners.Corners[static_cast<std::size_t>(k)] / 4 * 4;
    column.insert(column.end(), ids, ids + 4);
  }
  std::sort(column.begin(), column.end());
  column.erase(std::unique(column.begin(), column.end()), column.end());
}

/// A matrix of zeros with an entry for each edge, both ways, and each vertex.
SparseMatrix AdjacencyPattern(const TetrahedralMesh& mesh, const VertexCorners& corners)
{
  const Index points = mesh.NumberOfPoints();
  SparseMatrix pattern(points, points);
  const auto eachColumn = [&](const auto& visit) {
    ParallelFor(points, FineGrain, [&](std::int64_t begin, std::int64_t end) {
      std::vector<Index> column;
      for (std::int64_t v = begin; v < end; ++v)
      {
        FindColumn(mesh, corners, static_cast<Index>(v), column);
        visit(v, column);
      }
    });
  };
  Index* start = pattern.outerIndexPtr();
  start[0] = 0;
  eachColumn([&](std::int64_t v, const auto& column) { start[v + 1] = static_cast<Index>(column.size()); });
  for (Index v = 0; v < points; ++v)
  {
    start[v + 1] += start[v];
  }
  pattern.resizeNonZeros(start[points]);
  eachColumn([&](std::int64_t v, const auto& column) {
    std::copy(column.begin(), column.end(), pattern.innerIndexPtr() + pattern.outerIndexPtr()[v]);
  });
  std::fill_n(pattern.valuePtr(), pattern.nonZeros(), 0.0);
  return pattern;
}
} // namespace

Eigen::VectorXd LumpedMass(const TetrahedralMesh& mesh)
{
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    const double quarter = std::abs(SixfoldVolume(mesh, t)) / 24.0;
    for (int k = 0; k < 4; ++k)
    {
      mass[mesh.Tetrahedra(t, k)] += quarter;
    }
  }
  return mass;
}

VolumeTensors DirectionTensors(const TetrahedralMesh& mesh, const PointMatrix& directions, double ratio)
{
  const double across = std::pow(ratio, -2.0 / 3.0);
  VolumeTensors tensors(mesh.NumberOfTetrahedra(), 6);
  ParallelFor(mesh.NumberOfTetrahedra(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
    {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 4; ++k)
      {
        const Eigen::Vector3d given = directions.row(mesh.Tetrahedra(t, k)).transpose();
        const Eigen::Vector3d direction = given.stableNormalized();
        const bool hasDirection = direction.squaredNorm() > 0.5;
        const Eigen::Matrix3d stretched = across *
          (Eigen::Matrix3d::Identity() + (ratio * ratio - 1.0) * direction * direction.transpose());
        sum += hasDirection ? stretched : Eigen::Matrix3d::Identity();
      }
      sum /= std::cbrt(sum.determinant());
      tensors.row(t) << sum(0, 0), sum(0, 1), sum(0, 2), sum(1, 1), sum(1, 2), sum(2, 2);
    }
  });
  return tensors;
}

SparseMatrix VolumeStiffness(const TetrahedralMesh& mesh, const VolumeTensors& tensors)
{
  LargeArray<std::array<double, 6>> pairs(static_cast<std::size_t>(mesh.NumberOfTetrahedra()));
  ParallelFor(mesh.NumberOfTetrahedra(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
    {
      FillPairs(mesh, tensors, static_cast<Index>(t), pairs[static_cast<std::size_t>(t)].data());
    }
  });
  const VertexCorners corners(mesh);
  SparseMatrix stiffness = AdjacencyPattern(mesh, corners);
  ParallelFor(mesh.NumberOfPoints(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      const Index* first = stiffness.innerIndexPtr() + stiffness.outerIndexPtr()[v];
      const Index* last = stiffness.innerIndexPtr() + stiffness.outerIndexPtr()[v + 1];
      double* values = stiffness.valuePtr() + stiffness.outerIndexPtr()[v];
      double& diagonal = values[std::lower_bound(first, last, static_cast<Index>(v)) - first];
      for (std::int64_t k = corners.Start[v]; k < corners.Start[static_cast<std::size_t>(v) + 1]; ++k)
      {
        const std::int64_t corner = corners.Corners[static_cast<std::size_t>(k)];
        for (int j = 0; j < 4; ++j)
        {
          if (j != corner % 4)
          {
            const double entry = pairs[static_cast<std::size_t>(corner / 4)][PairOf[corner % 4][j]];
            values[std::lower_bound(first, last, mesh.Tetrahedra(corner / 4, j)) - first] += entry;
            diagonal -= entry;
          }
        }
      }
    }
  });
  return stiffness;
}

Eigen::VectorXd BoundaryMass(const TetrahedralMesh& mesh, const std::vector<FaceVertices>& faces,
  const std::function<bool(const FaceVertices&)>& isCounted)
{
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
  for (const FaceVertices& face : faces)
  {
    if (!isCounted || isCounted(face))
    {
      const Eigen::Vector3d origin = mesh.Points.row(face[0]);
      const Eigen::Vector3d first = mesh.Points.row(face[1]).transpose() - origin;
      const Eigen::Vector3d second = mesh.Points.row(face[2]).transpose() - origin;
      for (const Index v : face)
      {
        mass[v] += first.cross(second).norm() / 6.0;
      }
    }
  }
  return mass;
}

} // namespace surfsynth
