// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Diagonals of inverses of a sparse matrix by selected inversion [Takahashi1973], and of their products with a diagonal
/// matrix. Private to the solvers.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Solvers/SupernodalAnalysis.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Computes the diagonals of A^-1 (M A^-1)^k for k = 0 .. powers - 1, exactly, [n, powers] float64, rows in the order of
/// the matrix.
///
/// (A + e M)^-1 is the power series of (-e)^k A^-1 (M A^-1)^k. Elimination and selected inversion are carried out on
/// truncated power series in e, so that one pass over the supernodes gives all diagonals, by dense algebra: in about
/// 1, 3, 6 or 9 times the time of a factorisation for 1 to 4 powers, in memory of 2 powers times the factor. Runs on one
/// thread.
/// @param analysis order and supernodes of @p matrix
/// @param matrix A, [n, n], symmetric positive definite, both triangles stored
/// @param mass the diagonal of M, [n], at least 0
/// @param powers number of diagonals, at least 1
/// @throws SolverFailure when a pivot is not positive; Cancelled.
Eigen::MatrixXd SelectedInverseDiagonals(const SupernodalAnalysis& analysis, const SparseMatrix& matrix,
  const Eigen::VectorXd& mass, int powers, const Progress& progress);

} // namespace surfsynth
