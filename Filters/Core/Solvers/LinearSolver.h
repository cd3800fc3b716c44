// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Common interface of the solvers of linear equations.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Right-hand sides and solutions, row-major [V, K]: one row per vertex, so that all right-hand sides of a vertex are
/// contiguous and one pass over the factor serves them all.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Solver of A x = b for a symmetric positive definite sparse A, [V, V], that is set up once. Its functions may be called
/// from several threads.
class LinearSolver
{
public:
  virtual ~LinearSolver() = default;

  /// Number of rows of the matrix, V.
  virtual Index Size() const = 0;
  /// Order of the solver's rows, [V]: the vertex of each row.
  virtual const std::vector<Index>& Order() const = 0;
  /// Replaces right-hand sides whose rows are in the solver's own order by the solutions.
  /// @param rightHandSides [V, K] with K 1 or a multiple of Granularity(), rows contiguous
  virtual void SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress = {}) const = 0;
  /// Does the same for any number of right-hand sides, [V, K], whose rows are in the order of vertices.
  virtual void SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides) const = 0;
  /// Divisor of the number of right-hand sides that SolveOrderedInPlace() takes, unless that is 1.
  virtual Index Granularity() const = 0;
  /// Number of right-hand sides, zeros included, in which SolveOrderedInPlace() takes @p count of them.
  Eigen::Index PaddedCount(Eigen::Index count) const
  {
    const Eigen::Index granularity = this->Granularity();
    return count == 1 ? 1 : (count + granularity - 1) / granularity * granularity;
  }
  /// || A x - b || / || b || in the Euclidean norm (0 when b = 0), for checking a solution.
  virtual double RelativeResidual(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide) const = 0;

protected:
  LinearSolver() = default;
  LinearSolver(LinearSolver&&) noexcept = default;
  LinearSolver& operator=(LinearSolver&&) noexcept = default;
};

} // namespace surfsynth
