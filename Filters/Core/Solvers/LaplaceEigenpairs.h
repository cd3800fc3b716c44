// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The lowest eigenpairs of the Laplace-Beltrami operator.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Eigenpairs of L phi = lambda M phi ([Kuai2026], equation 2), ascending in lambda.
struct Eigenpairs
{
  Eigen::VectorXd Values;  ///< [k] float64, 1 / square world units, clamped at 0 from below
  Eigen::MatrixXd Vectors; ///< [V, k] float64, phi_i^T M phi_j = delta_ij; the entry of largest modulus is positive
};

/// Computes the @p count lowest eigenpairs, by the implicitly restarted Lanczos method [Lehoucq1998] of Spectra on the
/// shifted inverse of M^-1/2 L M^-1/2, whose factor is a CholeskySolver. Vertices of mass 0 get 0. Deterministic.
///
/// @param stiffness L, [V, V], see CotangentStiffness()
/// @param mass [V], see LumpedMass()
/// @param stiffness L, [V, V], see CotangentStiffness()
/// @param mass [V], see LumpedMass()
/// @param count in [1, number of vertices with mass - 1].
/// @throws InvalidInput when @p count is out of range.
/// @throws SolverFailure when fewer than @p count pairs converge to 1e-10.
Eigenpairs LowestLaplaceEigenpairs(
  const SparseMatrix& stiffness, const Eigen::VectorXd& mass, Index count, const Progress& progress = {});

} // namespace surfsynth
