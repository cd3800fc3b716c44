// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SurfaceSmoothing.h"

#include "Core/Operators/SurfaceOperators.h"

namespace surfsynth
{

namespace
{
/// Returns (M + l^2 L) / area; 1 on the diagonal of unused points.
SparseMatrix ScaledOperator(
  const TriangleMesh& mesh, const MeshTopology& topology, double length, double area, const Eigen::VectorXd& weights)
{
  SparseMatrix matrix = CotangentStiffness(mesh, topology) * (length * length / area);
  for (Eigen::Index v = 0; v < weights.size(); ++v)
  {
    matrix.coeffRef(v, v) += weights[v] > 0.0 ? weights[v] : 1.0;
  }
  return matrix;
}
} // namespace

SurfaceSmoothing::SurfaceSmoothing(const TriangleMesh& mesh, const MeshTopology& topology, double length)
  : SurfaceSmoothing(mesh, topology, length, LumpedMass(mesh, topology))
{}

SurfaceSmoothing::SurfaceSmoothing(
  const TriangleMesh& mesh, const MeshTopology& topology, double length, const Eigen::VectorXd& mass)
  : Weights(mass / mass.sum())
  , Solver(ScaledOperator(mesh, topology, length, mass.sum(), this->Weights))
{}

RowMatrix SurfaceSmoothing::Apply(RowMatrix rows) const
{
  for (Eigen::Index v = 0; v < this->Weights.size(); ++v)
  {
    rows.row(v) = this->Weights[v] > 0.0 ? Eigen::RowVectorXd(this->Weights[v] * rows.row(v))
                                         : Eigen::RowVectorXd::Zero(rows.cols());
  }
  this->Solver.SolveInPlace(rows);
  return rows;
}

} // namespace surfsynth
