// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Operators/SurfaceOperators.h"

#include "Core/Common/LargeArray.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
Eigen::Vector3d Point(const TriangleMesh& mesh, Index v) { return mesh.Points.row(v).transpose(); }

Eigen::Index Faces(const TriangleMesh& mesh) { return mesh.Triangles.rows(); }

/// Contribution of a triangle to the row of the stiffness matrix that belongs to one of its corners.
struct CornerWeights
{
  double Next; ///< half the cotangent of the angle at the last corner, for the edge to the next one
  double Last; ///< half the cotangent of the angle at the next corner, for the edge to the last one
  Index NextVertex;
  Index LastVertex;
};

/// The weights of all corners, [3 F], in the order of topology.VertexTriangles. @p halfWeights(f, half) gives those of the
/// edges opposite to the corners of triangle f: half[k] is minus the entry of its element matrix for the other two.
template <typename HalfWeights>
LargeArray<CornerWeights> WeightsOfCorners(
  const TriangleMesh& mesh, const MeshTopology& topology, const HalfWeights& halfWeights)
{
  LargeArray<CornerWeights> weights(topology.CornerPlace.size());
  ParallelFor(Faces(mesh), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto t = mesh.Triangles.row(f);
      double half[3];
      halfWeights(f, half);
      for (int k = 0; k < 3; ++k)
      {
        const int next = (k + 1) % 3;
        const int last = (k + 2) % 3;
        weights[topology.CornerPlace[3 * f + k]] = { half[last], half[next], t(next), t(last) };
      }
    }
  });
  return weights;
}

LargeArray<CornerWeights> CotangentWeights(
  const TriangleMesh& mesh, const MeshTopology& topology, double squaredAreaShift)
{
  return WeightsOfCorners(mesh, topology, [&](std::int64_t f, double* half) {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d edge[3] = { Point(mesh, t(2)) - Point(mesh, t(1)), Point(mesh, t(0)) - Point(mesh, t(2)),
      Point(mesh, t(1)) - Point(mesh, t(0)) };
    const double doubleArea = std::sqrt(edge[0].cross(edge[1]).squaredNorm() + squaredAreaShift);
    for (int k = 0; k < 3; ++k)
    {
      half[k] = -0.5 * edge[(k + 1) % 3].dot(edge[(k + 2) % 3]) / doubleArea;
    }
  });
}

/// Triangle laid flat: v0 at the origin, v1 at (Length, 0), v2 at (X, Y).
struct FlatTriangle
{
  double Length;
  double X;
  double Y;
  double DoubleArea;
};

FlatTriangle Flatten(const TriangleMesh& mesh, std::int64_t f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::Vector3d first = Point(mesh, t(1)) - Point(mesh, t(0));
  const Eigen::Vector3d second = Point(mesh, t(2)) - Point(mesh, t(0));
  const double length = first.norm();
  const double doubleArea = first.cross(second).norm();
  return { length, first.dot(second) / length, doubleArea / length, doubleArea };
}

/// Column pointers and row ids of a matrix with an entry for each edge, both ways, and each vertex.
SparseMatrix AdjacencyPattern(const MeshTopology& topology)
{
  const Index points = topology.NumberOfPoints();
  SparseMatrix pattern(points, points);
  pattern.resizeNonZeros(static_cast<Eigen::Index>(topology.Neighbors.size()) + points);
  for (Index v = 0; v <= points; ++v)
  {
    pattern.outerIndexPtr()[v] = topology.NeighborStart[v] + v;
  }
  ParallelFor(points, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      const Index* first = topology.Neighbors.data() + topology.NeighborStart[v];
      const Index* last = topology.Neighbors.data() + topology.NeighborStart[v + 1];
      const Index* above = std::lower_bound(first, last, static_cast<Index>(v));
      Index* rows = pattern.innerIndexPtr() + pattern.outerIndexPtr()[v];
      rows = std::copy(first, above, rows);
      *rows++ = static_cast<Index>(v);
      std::copy(above, last, rows);
    }
  });
  return pattern;
}
} // namespace

Eigen::VectorXd FaceAreas(const TriangleMesh& mesh)
{
  Eigen::VectorXd areas(Faces(mesh));
  ParallelFor(Faces(mesh), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      areas[f] = 0.5 * AreaVector(mesh, static_cast<Index>(f)).norm();
    }
  });
  return areas;
}

Eigen::VectorXd LumpedMass(const TriangleMesh& mesh, const MeshTopology& topology)
{
  const Eigen::VectorXd areas = FaceAreas(mesh);
  Eigen::VectorXd mass(mesh.Points.rows());
  ParallelFor(mass.size(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      double sum = 0.0;
      for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
      {
        sum += areas[topology.VertexTriangles[k]];
      }
      mass[v] = sum / 3.0;
    }
  });
  return mass;
}

Eigen::VectorXd LumpedMass(const TriangleMesh& mesh) { return LumpedMass(mesh, MeshTopology(mesh)); }

namespace
{
/// Sum of the element matrices whose weights are @p weights.
SparseMatrix AssembleStiffness(const LargeArray<CornerWeights>& weights, const MeshTopology& topology)
{
  SparseMatrix stiffness = AdjacencyPattern(topology);
  ParallelFor(topology.NumberOfPoints(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      const Index* rows = stiffness.innerIndexPtr() + stiffness.outerIndexPtr()[v];
      double* values = stiffness.valuePtr() + stiffness.outerIndexPtr()[v];
      const Index count = stiffness.outerIndexPtr()[v + 1] - stiffness.outerIndexPtr()[v];
      const auto entry = [&](Index row) -> double& {
        if (count > 32)
        {
          return values[std::lower_bound(rows, rows + count, row) - rows];
        }
        // Counting the smaller ids has no branch to mispredict, unlike a search.
        Index place = 0;
        for (Index k = 0; k < count; ++k)
        {
          place += rows[k] < row ? 1 : 0;
        }
        return values[place];
      };
      std::fill_n(values, count, 0.0);
      double diagonal = 0.0;
      for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
      {
        const CornerWeights& corner = weights[k];
        entry(corner.NextVertex) -= corner.Next;
        entry(corner.LastVertex) -= corner.Last;
        diagonal += corner.Next + corner.Last;
      }
      entry(static_cast<Index>(v)) = diagonal;
    }
  });
  return stiffness;
}

} // namespace

SparseMatrix CotangentStiffness(const TriangleMesh& mesh, const MeshTopology& topology, double squaredAreaShift)
{
  return AssembleStiffness(CotangentWeights(mesh, topology, squaredAreaShift), topology);
}

SparseMatrix DiffusionStiffness(const TriangleMesh& mesh, const MeshTopology& topology, const FaceTensors& tensors)
{
  const auto weights = WeightsOfCorners(mesh, topology, [&](std::int64_t f, double* half) {
    const FlatTriangle flat = Flatten(mesh, f);
    const Eigen::Vector2d edge[3] = { { flat.X - flat.Length, flat.Y }, { -flat.X, -flat.Y }, { flat.Length, 0.0 } };
    // Gradients are edges turned by a right angle: the tensor turned likewise is its adjugate.
    Eigen::Matrix2d turned;
    turned << tensors(f, 2), -tensors(f, 1), -tensors(f, 1), tensors(f, 0);
    for (int k = 0; k < 3; ++k)
    {
      half[k] = -0.5 * edge[(k + 1) % 3].dot(turned * edge[(k + 2) % 3]) / flat.DoubleArea;
    }
  });
  return AssembleStiffness(weights, topology);
}

FaceTensors DirectionTensors(const TriangleMesh& mesh, const PointMatrix& directions, double ratio)
{
  FaceTensors tensors(Faces(mesh), 3);
  ParallelFor(Faces(mesh), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto t = mesh.Triangles.row(f);
      const Eigen::Vector3d x = (Point(mesh, t(1)) - Point(mesh, t(0))).normalized();
      const Eigen::Vector3d y = AreaVector(mesh, static_cast<Index>(f)).normalized().cross(x);
      Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
      for (int k = 0; k < 3; ++k)
      {
        const Eigen::Vector3d direction = directions.row(t(k)).transpose();
        const Eigen::Vector2d inPlane(direction.dot(x), direction.dot(y));
        const double length = inPlane.norm();
        const bool isGiven = length > 1e-6 * direction.norm();
        const Eigen::Vector2d unit = isGiven ? Eigen::Vector2d(inPlane / length) : Eigen::Vector2d::Zero();
        sum += (isGiven ? 1.0 / ratio : 1.0) * Eigen::Matrix2d::Identity() +
          (ratio - 1.0 / ratio) * unit * unit.transpose();
      }
      sum /= std::sqrt(sum.determinant());
      tensors.row(f) << sum(0, 0), sum(0, 1), sum(1, 1);
    }
  });
  return tensors;
}

Eigen::VectorXd BoundaryMass(
  const TriangleMesh& mesh, const MeshTopology& topology, const std::function<bool(Index, Index)>& isCounted)
{
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.Points.rows());
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      const Index other = topology.Neighbors[k];
      if (topology.EdgeTriangles[k] == 1 && (!isCounted || isCounted(std::min(v, other), std::max(v, other))))
      {
        mass[v] += 0.5 * (Point(mesh, v) - Point(mesh, other)).norm();
      }
    }
  }
  return mass;
}

SparseMatrix CotangentStiffness(const TriangleMesh& mesh) { return CotangentStiffness(mesh, MeshTopology(mesh)); }

SparseRowMatrix IntrinsicGradient(const TriangleMesh& mesh)
{
  const Index faces = mesh.NumberOfTriangles();
  SparseRowMatrix gradient(2 * faces, mesh.NumberOfPoints());
  gradient.resizeNonZeros(6 * static_cast<Eigen::Index>(faces));
  for (Index row = 0; row <= 2 * faces; ++row)
  {
    gradient.outerIndexPtr()[row] = 3 * row;
  }
  ParallelFor(faces, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto t = mesh.Triangles.row(f);
      const FlatTriangle flat = Flatten(mesh, f);
      const double rows[2][3] = { { -flat.Y, flat.Y, 0.0 }, { flat.X - flat.Length, -flat.X, flat.Length } };
      // Columns in ascending order, as compressed rows want them.
      int order[3] = { 0, 1, 2 };
      std::sort(order, order + 3, [&](int a, int b) { return t(a) < t(b); });
      for (int component = 0; component < 2; ++component)
      {
        for (int k = 0; k < 3; ++k)
        {
          const std::int64_t entry = 6 * f + 3 * component + k;
          gradient.innerIndexPtr()[entry] = t(order[k]);
          gradient.valuePtr()[entry] = rows[component][order[k]] / flat.DoubleArea;
        }
      }
    }
  });
  return gradient;
}

VertexFrames TangentFrames(const TriangleMesh& mesh, const MeshTopology& topology)
{
  const Index points = mesh.NumberOfPoints();
  VertexFrames frames{ PointMatrix(points, 3), PointMatrix(points, 3), PointMatrix(points, 3) };
  ParallelFor(points, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double area = 0.0;
      for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
      {
        const Eigen::Vector3d normal = AreaVector(mesh, topology.VertexTriangles[k]);
        sum += normal;
        area += normal.norm();
      }
      const double length = sum.norm();
      const Eigen::Vector3d normal = length > 1e-12 * area ? Eigen::Vector3d(sum / length)
                                                           : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
      // The world axis least aligned with the normal, projected to the tangent plane.
      Eigen::Index axis = 0;
      normal.cwiseAbs().minCoeff(&axis);
      const Eigen::Vector3d tangent = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
      frames.Normal.row(v) = normal.transpose();
      frames.X.row(v) = tangent.transpose();
      frames.Y.row(v) = normal.cross(tangent).transpose();
    }
  });
  return frames;
}

double LaplaceBeltramiNorm(const SparseMatrix& stiffness, const Eigen::VectorXd& mass)
{
  // Row i of M^-1 L is row i of L over M_ii; L is symmetric, so its column will do. Summed column by column, and the
  // columns in a fixed order, so that the result does not depend on the number of threads.
  Eigen::VectorXd squares(stiffness.cols());
  ParallelFor(stiffness.cols(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      double sum = 0.0;
      for (SparseMatrix::InnerIterator entry(stiffness, v); entry; ++entry)
      {
        sum += entry.value() * entry.value();
      }
      squares[v] = mass[v] > 0.0 ? sum / (mass[v] * mass[v]) : 0.0;
    }
  });
  double total = 0.0;
  for (const double square : squares)
  {
    total += square;
  }
  return std::sqrt(total);
}

} // namespace surfsynth
