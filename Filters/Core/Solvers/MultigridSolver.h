// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conjugate gradients with a multigrid preconditioner: for matrices whose factor is too large.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Solvers/LinearSolver.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Options of MultigridSolver.
struct MultigridOptions
{
  /// Largest relative residual || b - A x || / || b || of a solution, in the Euclidean norm; 1e-14 ... 0.1.
  double Tolerance = 1e-10;
  /// Largest number of iterations; at least 1.
  int MaximumIterations = 300;
  /// Bytes that EstimateMemory() for one right-hand side may give; 0 for what the process can still allocate.
  std::uint64_t MemoryLimit = 0;
};

/// Solves A x = b for a symmetric positive definite sparse A by conjugate gradients [Hestenes1952] in double precision,
/// preconditioned by one V-cycle of smoothed aggregation [Vanek1996] in single precision, with Chebyshev polynomials of
/// the fourth kind [Lottes2023] as the smoother.
///
/// Made for the screened Poisson equation, A = L + tau M with the stiffness L and the mass M, on triangles and on
/// tetrahedra, whose solutions are smooth: functions that are nearly constant must be the ones that A maps to nearly 0.
/// Time and memory are linear in the number of entries, where those of a factor are not (surfaces: n log n entries,
/// volumes: n^(4/3)). The number of iterations hardly depends on the size. A factor is faster while it fits.
///
/// The hierarchy is built once in the constructor; Solve() may then be called from several threads. A column of the
/// solution has the same bits whether it is solved alone or with others, and for every number of threads.
class MultigridSolver : public LinearSolver
{
public:
  /// Builds the hierarchy.
  /// @param matrix [V, V] with both triangles stored; moved in, it is freed early
  /// @throws InvalidInput when it is not square, not finite or not symmetric (each entry to 1e-10 of itself or 1e-14 of
  /// the largest), an option is out of range, or the estimated memory exceeds the limit.
  /// @throws SolverFailure when a diagonal entry is not positive, or a coarse matrix is not positive definite.
  /// @throws Cancelled
  explicit MultigridSolver(SparseMatrix matrix, const MultigridOptions& options = {}, const Progress& progress = {});
  ~MultigridSolver() override;
  MultigridSolver(MultigridSolver&&) noexcept;
  MultigridSolver& operator=(MultigridSolver&&) noexcept;

  /// Solution for one right-hand side of length V. Same errors as SolveInPlace().
  Eigen::VectorXd Solve(const Eigen::VectorXd& rightHandSide) const;

  /// Replaces the right-hand sides, [V, K], by the solutions: eight columns together, threads share the rows. Memory
  /// beyond the hierarchy: about 56 bytes for each vertex and each column solved together.
  /// @throws InvalidInput when the number of rows is wrong or an entry is not finite.
  /// @throws SolverFailure when the residual of a column does not reach the tolerance within the number of iterations,
  /// rounding does not let it (A is too ill-conditioned), or A is found not to be positive definite; Cancelled.
  void SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress) const;
  /// The same without progress.
  void SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides) const override;

  /// Replaces right-hand sides whose rows are in the solver's own order by the solutions: the number of the vertex in
  /// row r is Order()[r]. Same errors as SolveInPlace().
  /// @param rightHandSides [V, K]. Not checked for finite entries.
  void SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress = {}) const override;
  Index Granularity() const override { return 1; }
  /// Order of the solver's rows, [V]: the vertex of each row.
  const std::vector<Index>& Order() const override;

  /// || A x - b || / || b || in the Euclidean norm (0 when b = 0), for checking a solution.
  /// @throws InvalidInput when a length is wrong.
  double RelativeResidual(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide) const override;

  /// A values for all columns of @p values, [V, K].
  /// @throws InvalidInput when the number of rows is wrong.
  RowMatrix Multiply(const RowMatrix& values) const;

  /// Largest number of iterations that a column of any call so far took.
  int Iterations() const;
  /// Largest relative residual of a solution of any call so far.
  double LargestResidual() const;

  /// Number of rows of the matrix, V.
  Index Size() const override;
  /// Number of levels, the finest included.
  int NumberOfLevels() const;
  /// Entries of the matrices of all levels over those of the given one.
  double OperatorComplexity() const;
  /// Bytes that the solver holds between calls.
  std::int64_t MemoryInUse() const;

  /// Estimated bytes that the constructor, the given matrix included, and a solve of @p columns right-hand sides
  /// allocate at most together.
  /// @param rows V
  /// @param entries entries of the matrix, both triangles
  /// @param columns right-hand sides solved together; more than 8 count as 8
  static std::uint64_t EstimateMemory(std::int64_t rows, std::int64_t entries, std::int64_t columns = 1);

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
