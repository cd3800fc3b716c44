// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sparse Cholesky: factor once, solve many.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/LinearSolver.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace surfsynth
{

/// Solves A x = b for a symmetric positive definite sparse A.
///
/// Factors once in the constructor; Solve() may then be called from several threads. With SURFACE_SYNTHESIS_CHOLMOD the
/// supernodal analysis is CHOLMOD's [Chen2008], and so is the ordering but for volumes from 10,000 rows on (see
/// NestedDissectionOrder()). The numeric factorisation is multifrontal on BLAS (see SupernodalFactor), and the triangular
/// solves are register-blocked over row-major right-hand sides. Without it everything is Eigen's SimplicialLLT. Both give
/// the same answers to 1e-10.
///
/// A column of the solution has the same bits whether it is solved alone or with others, and for every number of
/// threads.
class CholeskySolver : public LinearSolver
{
public:
  /// Factors @p matrix.
  /// @param matrix [V, V] with both triangles stored; only the lower one is read.
  /// @throws InvalidInput when it is not square, not finite or not symmetric (each entry to 1e-10 of itself or 1e-14 of
  /// the largest).
  /// @throws SolverFailure when it is not positive definite to working precision.
  explicit CholeskySolver(const SparseMatrix& matrix, const Progress& progress = {});
  ~CholeskySolver() override;
  CholeskySolver(CholeskySolver&&) noexcept;
  CholeskySolver& operator=(CholeskySolver&&) noexcept;

  /// Solution for one right-hand side of length V.
  /// @throws InvalidInput when the length is wrong or an entry is not finite.
  Eigen::VectorXd Solve(const Eigen::VectorXd& rightHandSide) const;

  /// Replaces the right-hand sides, [V, K], by the solutions, in parallel over blocks of columns.
  /// @throws InvalidInput when the number of rows is wrong or an entry is not finite.
  void SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides) const override;

  /// Replaces right-hand sides whose rows are in the solver's own order by the solutions, without copying: the number
  /// of the vertex in row r is Order()[r]. Made for callers that fill many right-hand sides themselves.
  /// @param rightHandSides [V, K] with K 1 or a multiple of ColumnGranularity (pad with zeros), rows contiguous. Not
  /// checked for finite entries.
  /// @throws InvalidInput when the shape is wrong; Cancelled.
  void SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress = {}) const override;
  /// Solves L^T x = b with the factor A = P^T L L^T P, for right-hand sides as those of SolveOrderedInPlace(): the
  /// solutions of independent normal numbers have the covariance A^-1. Same errors as SolveOrderedInPlace().
  void SolveTransposedOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress = {}) const;
  /// Order of the solver's rows, [V]: the vertex of each row.
  const std::vector<Index>& Order() const override;

  /// Number of right-hand sides that the registers hold together.
  static constexpr Index ColumnGranularity = 8;
  Index Granularity() const override { return ColumnGranularity; }
  /// Good number of right-hand sides for one pass over the factor.
  static constexpr Index BlockColumns = 32;

  /// || A x - b || / || b || in the Euclidean norm (0 when b = 0), for checking a solution.
  /// @throws InvalidInput when a length is wrong.
  double RelativeResidual(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide) const override;

  /// Natural logarithm of the determinant of A.
  double LogDeterminant() const;

  /// Diagonals of A^-1 (M A^-1)^k for k = 0 .. powers - 1, [V, powers] float64, exactly: by selected inversion
  /// [Takahashi1973] on truncated power series, with CHOLMOD, in about 1, 3, 6 or 9 times the time of the
  /// factorisation for 1 to 4 powers; without CHOLMOD by a solve for each vertex, in quadratic time. On one thread.
  /// @param mass the diagonal of M, [V], at least 0
  /// @param powers number of diagonals, at least 1
  /// @throws InvalidInput when the mass has a wrong length, is negative or not finite, or powers is below 1; Cancelled.
  Eigen::MatrixXd InverseDiagonals(const Eigen::VectorXd& mass, int powers, const Progress& progress = {}) const;

  /// A, with ascending rows in each column.
  const SparseMatrix& Matrix() const;
  /// Number of rows of the matrix, V.
  Index Size() const override;
  /// Entries of the stored factor, explicit zeros of relaxed supernodes included.
  std::int64_t FactorEntries() const;

  /// Estimated bytes of the factor, from sizes alone: 12 log2 V - 80 entries in a row for the matrices of surfaces (up to
  /// 9 entries in a row on average), 3.4 V^(1/2) for those of volumes, 2.7 V^(1/2) from 10,000 rows on with
  /// SURFACE_SYNTHESIS_CHOLMOD. Between the factor's and about three times that.
  /// @param rows V
  /// @param entries entries of the matrix, both triangles
  static std::uint64_t EstimateMemory(std::int64_t rows, std::int64_t entries);

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// One-off solve: factors @p matrix and solves for one right-hand side. Same errors as CholeskySolver.
Eigen::VectorXd SolveCholesky(const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide);

} // namespace surfsynth
