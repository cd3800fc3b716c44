// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sparse Cholesky for many matrices of one pattern, as Newton's method needs it.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <memory>

namespace surfsynth
{

/// Factors and solves A x = b for symmetric positive definite matrices that differ in their values only: the order and the
/// supernodes are found once. On the calling thread.
class RepeatedCholesky
{
public:
  /// Analyses the pattern of @p matrix, [N, N] with both triangles and ascending rows.
  /// @throws SolverFailure when the factor would have more than 2^31 entries.
  explicit RepeatedCholesky(const SparseMatrix& matrix);
  ~RepeatedCholesky();
  RepeatedCholesky(RepeatedCholesky&&) noexcept;
  RepeatedCholesky& operator=(RepeatedCholesky&&) noexcept;

  /// Factors @p matrix, of the pattern that was analysed, and solves for one right-hand side of length N.
  /// @throws SolverFailure when it is not positive definite to working precision; Cancelled.
  Eigen::VectorXd Solve(
    const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide, const Progress& progress = {});

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
