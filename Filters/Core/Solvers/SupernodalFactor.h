// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Numeric half of a supernodal Cholesky factorisation: the multifrontal method [Duff1983] [Liu1992]. Private to the
/// solvers.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Solvers/SupernodalAnalysis.h"
#include "Core/Solvers/SupernodalKernels.h"

#include <vector>

namespace surfsynth
{

/// The factor P A P^T = L L^T: one dense panel for each supernode, column-major.
class SupernodalFactor
{
public:
  /// Factors by the multifrontal method: each front gathers its entries of A and the updates of its children, is
  /// factored by dense BLAS, and passes its own update on. Disjoint subtrees run in parallel; each front does the same
  /// arithmetic whatever the number of threads, so that the factor has the same bits.
  /// @throws SolverFailure when a pivot is not positive; Cancelled.
  SupernodalFactor(SupernodalAnalysis analysis, const SparseMatrix& matrix, const Progress& progress);

  /// Solves for @p count right-hand sides, 1 or a multiple of 8, in place: row-major [n, count], rows in elimination order.
  /// A column's result has the same bits for every count and place.
  /// @throws Cancelled; the right-hand sides are then overwritten in part.
  void SolveInPlace(double* rightHandSides, std::int64_t count, const Progress& progress) const;

  /// Solves L^T x = b like SolveInPlace(): the second half of a solve.
  void SolveTransposedInPlace(double* rightHandSides, std::int64_t count, const Progress& progress) const;

  /// Natural logarithm of the determinant of A, summed in the order of the columns.
  double LogDeterminant() const;

  /// Order and supernodes of the factor.
  const SupernodalAnalysis& Analysis() const { return this->Symbolic; }
  /// Number of stored entries, explicit zeros included.
  std::int64_t Entries() const { return this->Symbolic.ValueStart.back(); }

private:
  SupernodalPanel Panel(Index s) const;

  SupernodalAnalysis Symbolic;
  LargeArray<double> Values;           ///< panels, from Symbolic.ValueStart
  std::vector<double> InverseDiagonal; ///< [n]
};

} // namespace surfsynth
