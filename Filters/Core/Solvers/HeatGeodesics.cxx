// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/HeatGeodesics.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
/// Columns that are worked on together while the gradients are normalised.
constexpr Index Together = CholeskySolver::BlockColumns;

double HeatTime(const TriangleMesh& mesh)
{
  double length = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    for (int k = 0; k < 3; ++k)
    {
      length += (mesh.Points.row(t(k)) - mesh.Points.row(t((k + 1) % 3))).norm() / (3.0 * mesh.NumberOfTriangles());
    }
  }
  const BoundingBox box = ComputeBoundingBox(mesh);
  const double step = std::max(length, (box.Upper - box.Lower).norm() / 200.0);
  return step * step;
}

/// A_f grad phi_k for the three corners: half the opposite edge, turned inwards by a quarter, in the frame whose x axis
/// is the first edge.
Eigen::Matrix<double, 1, 6> CornerGradients(const TriangleMesh& mesh, Index f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::Vector3d u = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
  const Eigen::Vector3d v = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
  const double x1 = u.norm();
  const double x2 = u.dot(v) / x1;
  const double y2 = u.cross(v).norm() / x1;
  Eigen::Matrix<double, 1, 6> gradients;
  gradients << -y2, x2 - x1, y2, -x2, 0.0, x1;
  return 0.5 * gradients;
}

/// A diagonal that makes L regular: at one vertex of each component, where the solution then is 0, and at vertices that
/// no triangle uses. (Right-hand sides whose sum is 0 on each component: summing the equations shows it.)
Eigen::VectorXd Pins(const SparseMatrix& stiffness, const MeshComponents& components)
{
  const Eigen::VectorXd diagonal = stiffness.diagonal();
  Eigen::VectorXd pins = Eigen::VectorXd::Zero(diagonal.size());
  std::vector<bool> pinned(static_cast<std::size_t>(components.Count), false);
  for (Index v = 0; v < pins.size(); ++v)
  {
    const Index component = components.OfVertex[v];
    if (component < 0)
    {
      pins[v] = 1.0;
    }
    else if (!pinned[component])
    {
      pinned[component] = true;
      pins[v] = diagonal[v];
    }
  }
  return pins;
}
} // namespace

HeatGeodesics::HeatGeodesics(const TriangleMesh& mesh, const MeshTopology& topology, const Progress& progress)
  : Triangles(mesh.Triangles)
  , WeightedGradients(mesh.NumberOfTriangles(), 6)
  , VertexMass(LumpedMass(mesh, topology))
  , Parts(ComputeComponents(topology, VertexMass))
{
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    this->WeightedGradients.row(f) = CornerGradients(mesh, f);
  }
  const SparseMatrix stiffness = CotangentStiffness(mesh, topology);
  SparseMatrix matrix = HeatTime(mesh) * stiffness;
  for (Index v = 0; v < matrix.cols(); ++v)
  {
    matrix.coeffRef(v, v) += this->Parts.OfVertex[v] < 0 ? 1.0 : this->VertexMass[v];
  }
  this->Solvers.emplace_back(matrix, SubProgress(progress, 0.0, 0.5));
  matrix = stiffness;
  matrix.diagonal() += Pins(stiffness, this->Parts);
  this->Solvers.emplace_back(matrix, SubProgress(progress, 0.5, 1.0));
}

void HeatGeodesics::RequireSources(const std::vector<Index>& sources) const
{
  for (const Index source : sources)
  {
    if (source < 0 || source >= this->VertexMass.size() || this->Parts.OfVertex[source] < 0)
    {
      throw InvalidInput("HeatGeodesics: source " + std::to_string(source) +
        " is no vertex of a triangle; one of the mesh's " + std::to_string(this->VertexMass.size()) +
        " vertices is needed.");
    }
  }
}

RowMatrix HeatGeodesics::Distances(const std::vector<Index>& sources) const
{
  this->RequireSources(sources);
  const auto columns = static_cast<Index>(sources.size());
  RowMatrix heat = RowMatrix::Zero(this->VertexMass.size(), columns);
  for (Index k = 0; k < columns; ++k)
  {
    heat(sources[k], k) = 1.0;
  }
  this->Solvers[0].SolveInPlace(heat);
  RowMatrix distances = RowMatrix::Zero(heat.rows(), columns);
  ParallelTasks((columns + Together - 1) / Together, [&](std::int64_t block) {
    const auto first = static_cast<Index>(block * Together);
    this->AccumulateDivergence(heat, distances, first, std::min(Together, columns - first));
  });
  this->Solvers[1].SolveInPlace(distances);
  this->ShiftToSource(sources, distances);
  return distances;
}

/// Adds G^T A X to the columns [firstColumn, firstColumn + columns). The heat of one vertex is contiguous over columns,
/// so the loops over k are vector code.
void HeatGeodesics::AccumulateDivergence(
  const Eigen::Ref<const RowMatrix>& heat, Eigen::Ref<RowMatrix> divergence, Index firstColumn, Index columns) const
{
  const Eigen::Index width = heat.cols();
  for (Eigen::Index f = 0; f < this->Triangles.rows(); ++f)
  {
    const double* g = this->WeightedGradients.data() + 6 * f;
    const double* u[3];
    double* b[3];
    for (int corner = 0; corner < 3; ++corner)
    {
      const Eigen::Index place = this->Triangles(f, corner) * width + firstColumn;
      u[corner] = heat.data() + place;
      b[corner] = divergence.data() + place;
    }
    for (Index k = 0; k < columns; ++k)
    {
      // Scaled first: far from the source the squares of the heat would be too small for a number.
      const double largest = std::max({ std::abs(u[0][k]), std::abs(u[1][k]), std::abs(u[2][k]) });
      const double scale = largest > std::numeric_limits<double>::min() ? 1.0 / largest : 0.0;
      const double u0 = scale * u[0][k];
      const double u1 = scale * u[1][k];
      const double u2 = scale * u[2][k];
      const double x = g[0] * u0 + g[2] * u1 + g[4] * u2;
      const double y = g[1] * u0 + g[3] * u1 + g[5] * u2;
      const double norm = std::sqrt(x * x + y * y);
      const double inverse = norm > 0.0 ? -1.0 / norm : 0.0;
      b[0][k] += inverse * (g[0] * x + g[1] * y);
      b[1][k] += inverse * (g[2] * x + g[3] * y);
      b[2][k] += inverse * (g[4] * x + g[5] * y);
    }
  }
}

void HeatGeodesics::ShiftToSource(const std::vector<Index>& sources, RowMatrix& distances) const
{
  const Eigen::RowVectorXd atSource = Eigen::RowVectorXd::NullaryExpr(
    distances.cols(), [&](Eigen::Index k) { return distances(sources[k], k); });
  for (Eigen::Index v = 0; v < distances.rows(); ++v)
  {
    for (Eigen::Index k = 0; k < distances.cols(); ++k)
    {
      double& distance = distances(v, k);
      if (this->Parts.OfVertex[v] != this->Parts.OfVertex[sources[k]])
      {
        distance = std::numeric_limits<double>::infinity();
        continue;
      }
      if (!std::isfinite(distance))
      {
        throw SolverFailure("HeatGeodesics: the distance of vertex " + std::to_string(v) + " from vertex " +
          std::to_string(sources[k]) + " is not finite.");
      }
      distance = std::max(distance - atSource[k], 0.0);
    }
  }
}

} // namespace surfsynth
