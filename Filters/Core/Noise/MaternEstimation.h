// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parameters of Matérn fields by maximum likelihood, from observations.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Options of an estimation.
struct MaternEstimationOptions
{
  /// alpha of the field, 2, 3 or 4: see MaternFieldOptions::OperatorPower. The factors grow with it.
  int OperatorPower = 2;
  /// True estimates the standard deviation of independent errors of the observations; false takes it as 0 (1e-3 of that
  /// of the field, which keeps the system positive definite).
  bool Noise = true;
  /// True estimates a constant mean of each field; false takes it as 0.
  bool Mean = false;
};

/// A parameter above 0 with its uncertainty.
struct EstimatedParameter
{
  double Value = 0.0;         ///< of the largest likelihood
  double StandardError = 0.0; ///< of its logarithm, by the observed information
  double Lower = 0.0;         ///< of the interval of 95 %, Value exp(-1.96 StandardError)
  double Upper = 0.0;         ///< of the interval of 95 %, Value exp(1.96 StandardError)
};

/// Result of an estimation.
struct MaternEstimate
{
  EstimatedParameter CorrelationRange;  ///< world units, as MaternFieldOptions::CorrelationRange
  EstimatedParameter StandardDeviation; ///< of the field, as MaternFieldOptions::StandardDeviation
  /// Of the errors. All 0 when it is not estimated; Value, StandardError and Lower are 0 when the likelihood increases
  /// down to 1e-3 of the standard deviation of the field, which is then Upper.
  EstimatedParameter NoiseDeviation;
  Eigen::VectorXd Means;         ///< [R], of the fields
  double LogLikelihood = 0.0;    ///< at the estimate, natural logarithm
  std::int64_t Observations = 0; ///< n
  std::int64_t Fields = 0;       ///< R
  int Evaluations = 0;           ///< of the likelihood
};

/// Estimates correlation range, standard deviation and deviation of the errors of a Matérn field (NoiseModel::Matern in
/// CorrelationRange mode, smoothness alpha - 1) from R independent fields observed at n places.
///
/// The observations of a field are N(mu, sigma^2 (H Q^-1 H^T + eta^2 I)) with Q the precision of the field of unit
/// deviation. By the determinant lemma their likelihood takes the sparse factors of L + tau M and Q + H^T H / eta^2
/// only [Rue2005]: the cost of an evaluation is that of two factorisations and R solves, whatever the number of
/// observations. sigma and mu follow from the others; log range and log eta are found by a grid and the method of
/// Nelder and Mead [Nelder1965]. Standard errors are those of the inverse of the observed information in the
/// logarithms.
///
/// Of a single field on a surface of few ranges, range and deviation are known poorly, and the intervals are wide;
/// below about ten ranges squared of area they are too narrow as a rule.
/// @param matrix H, [n, V]: see ObservationMatrix()
/// @param values [n, R], finite
/// @throws InvalidInput when the shapes differ, there are fewer than 4 numbers or all are the same, the operator power is
/// none of 2, 3 and 4, or the likelihood increases up to the end of the ranges looked at, from the longest edge to 4
/// times the longest side of the bounding box: the text says which; SolverFailure when a matrix is not positive definite to working precision; Cancelled.
MaternEstimate EstimateMatern(const TriangleMesh& mesh, const MeshTopology& topology, const SparseRowMatrix& matrix,
  const Eigen::MatrixXd& values, const MaternEstimationOptions& options = {}, const Progress& progress = {});

} // namespace surfsynth
