// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Levels of an algebraic multigrid method by smoothed aggregation [Vanek1996]. Private to the solvers.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/SparseRows.h"

#include <array>
#include <optional>
#include <vector>

namespace surfsynth
{

/// One level. Its matrix is scaled to a unit diagonal, in single precision.
struct MultigridLevel
{
  /// Number of steps of the polynomial smoother, before and after the correction each.
  static constexpr int SmootherSteps = 2;

  SparseRows Matrix;       ///< scaled matrix in Single; on the finest level the given one in Value as well
  SparseRows Prolongation; ///< P, values in Single; empty on the last level
  SparseRows Restriction;  ///< P^T, values in Single; empty on the last level
  /// Factors of the smoother [Lottes2023], Chebyshev polynomials of the fourth kind: a step is d <- Direction d +
  /// Residual r, then x <- x + d.
  std::array<float, SmootherSteps> Direction{};
  std::array<float, SmootherSteps> Residual{};
};

/// Levels of a symmetric positive definite matrix from fine to coarse.
class MultigridHierarchy
{
public:
  /// Largest number of rows of a level that is factored.
  static constexpr Index FactoredRows = 800;

  /// Builds the levels, in parallel but for the aggregation.
  /// @param matrix [V, V], values in Value, which stay
  /// @throws SolverFailure when a diagonal entry is not positive or the coarsest matrix is not positive definite.
  MultigridHierarchy(SparseRows matrix, const Progress& progress);

  std::vector<MultigridLevel> Levels; ///< at least one
  LargeArray<double> Root;            ///< [V], square roots of the diagonal of the given matrix
  /// Factor of the last level; empty where relaxation alone solves it, as when all its rows are dominated by their
  /// diagonals.
  std::optional<CholeskySolver> Coarsest;

  /// Entries of the matrices of all levels over those of the finest.
  double OperatorComplexity() const;
  /// Bytes of all levels.
  std::int64_t Bytes() const;

private:
  void TakeRoots();
};

} // namespace surfsynth
