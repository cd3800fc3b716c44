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

/// Twice the area times the unit normal of triangle @p f.
Eigen::Vector3d AreaVector(const TriangleMesh& mesh, Index f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::Vector3d p = Point(mesh, t(0));
  return (Point(mesh, t(1)) - p).cross(Point(mesh, t(2)) - p);
}

Eigen::Index Faces(const TriangleMesh& mesh) { return mesh.Triangles.rows(); }

/// Contribution of a triangle to the row of the stiffness matrix that belongs to one of its corners.
struct CornerWeights
{
  double Next; ///< half the cotangent of the angle at the last corner, for the edge to the next one
  double Last; ///< half the cotangent of the angle at the next corner, for the edge to the last one
  Index NextVertex;
  Index LastVertex;
};

/// The weights of all corners, [3 F], in the order of topology.VertexTriangles.
LargeArray<CornerWeights> CotangentWeights(
  const TriangleMesh& mesh, const MeshTopology& topology, double squaredAreaShift)
{
  LargeArray<CornerWeights> weights(topology.CornerPlace.size());
  ParallelFor(Faces(mesh), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto t = mesh.Triangles.row(f);
      const Eigen::Vector3d edge[3] = { Point(mesh, t(2)) - Point(mesh, t(1)), Point(mesh, t(0)) - Point(mesh, t(2)),
        Point(mesh, t(1)) - Point(mesh, t(0)) };
      const double doubleArea = std::sqrt(edge[0].cross(edge[1]).squaredNorm() + squaredAreaShift);
      double half[3];
      for (int k = 0; k < 3; ++k)
      {
        half[k] = -0.5 * edge[(k + 1) % 3].dot(edge[(k + 2) % 3]) / doubleArea;
      }
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

SparseMatrix CotangentStiffness(const TriangleMesh& mesh, const MeshTopology& topology, double squaredAreaShift)
{
  const LargeArray<CornerWeights> weights = CotangentWeights(mesh, topology, squaredAreaShift);
  SparseMatrix stiffness = AdjacencyPattern(topology);
  ParallelFor(mesh.Points.rows(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
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
      const Eigen::Vector3d first = Point(mesh, t(1)) - Point(mesh, t(0));
      const Eigen::Vector3d second = Point(mesh, t(2)) - Point(mesh, t(0));
      // The triangle laid flat: v0 at the origin, v1 at (length, 0), v2 at (x, y).
      const double length = first.norm();
      const double doubleArea = first.cross(second).norm();
      const double x = first.dot(second) / length;
      const double y = doubleArea / length;
      const double rows[2][3] = { { -y, y, 0.0 }, { x - length, -x, length } };
      // Columns in ascending order, as compressed rows want them.
      int order[3] = { 0, 1, 2 };
      std::sort(order, order + 3, [&](int a, int b) { return t(a) < t(b); });
      for (int component = 0; component < 2; ++component)
      {
        for (int k = 0; k < 3; ++k)
        {
          const std::int64_t entry = 6 * f + 3 * component + k;
          gradient.innerIndexPtr()[entry] = t(order[k]);
          gradient.valuePtr()[entry] = rows[component][order[k]] / doubleArea;
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
