// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Linear equations whose rows lie distributed over ranks. Private to the library.
#pragma once

#include "Core/Common/Progress.h"
#include "Distributed/RankGroup.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Rows of a sparse matrix on one rank, in compressed form.
struct DistributedRows
{
  std::int64_t FirstRow = 0;         ///< row of the first of them
  std::int64_t NumberOfRows = 0;     ///< of all ranks
  std::vector<std::int32_t> Starts;  ///< [own rows + 1]
  std::vector<std::int32_t> Columns; ///< in the numbers of all ranks, ascending in each row
  std::vector<double> Values;        ///< of the entries
};

/// Solver of A x = b for a symmetric positive definite A by conjugate gradients of PETSc, preconditioned by the algebraic
/// multigrid of hypre (BoomerAMG [Henson2002]). The same rows on the same number of ranks give the same bits. All functions
/// but the last two are collective.
class DistributedSystem
{
public:
  /// Takes the rows and builds the multigrid hierarchy.
  /// @throws InvalidInput for more rows than PETSc's integers count.
  /// @throws SolverFailure with PETSc's words.
  DistributedSystem(const RankGroup& ranks, DistributedRows rows);
  ~DistributedSystem();
  DistributedSystem(const DistributedSystem&) = delete;
  DistributedSystem& operator=(const DistributedSystem&) = delete;

  /// Replaces the own rows of a right-hand side by those of the solution, to a relative residual of 1e-12 in the recursion
  /// of conjugate gradients.
  /// @return relative residual || A x - b || / || b || of the solution; 0 when b = 0
  /// @throws SolverFailure when 500 iterations do not suffice.
  /// @throws Cancelled on all ranks when @p progress of one returns false.
  double SolveInPlace(Eigen::VectorXd& values, const Progress& progress);

  int Iterations() const; ///< largest number of iterations of a solve so far

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
