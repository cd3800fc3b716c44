// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The lowest eigenpairs of the Laplace-Beltrami operator.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Eigenpairs of L phi = lambda M phi (equation 2 of the paper), ascending in lambda.
struct Eigenpairs
{
  Eigen::VectorXd Values;  ///< [k] float64, 1 / square world units, clamped at 0 from below
  Eigen::MatrixXd Vectors; ///< [V, k] float64, phi_i^T M phi_j = delta_ij; the entry of largest modulus is positive
};

/// The @p count lowest eigenpairs, by Lanczos (Spectra) on the shifted inverse of M^-1/2 L M^-1/2, whose factor is a
/// CholeskySolver. Vertices of mass 0 get 0. Deterministic.
///
/// @param count in [1, number of vertices with mass - 1].
/// @throws InvalidInput when @p count is out of range.
/// @throws SolverFailure when fewer than @p count pairs converge to 1e-10.
Eigenpairs LowestLaplaceEigenpairs(
  const SparseMatrix& stiffness, const Eigen::VectorXd& mass, Index count, const Progress& progress = {});

} // namespace surfsynth
