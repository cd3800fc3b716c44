// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Gaussian fields given observations: posterior samples, mean and standard deviation (kriging).
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/VolumePlace.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Returns the observation matrix H, [n, V]: row i holds the barycentric coordinates of place i, so that H f are the
/// values of f at the places.
/// @throws InvalidInput when a place has no triangle of @p mesh.
SparseRowMatrix ObservationMatrix(const TriangleMesh& mesh, const std::vector<SurfacePlace>& places);
/// Does the same in a volume.
/// @throws InvalidInput when a place has no tetrahedron of @p mesh.
SparseRowMatrix ObservationMatrix(const TetrahedralMesh& mesh, const std::vector<VolumePlace>& places);

/// Field of mean zero and covariance C on V vertices, given n observations y = H f + e, e ~ N(0, diag(s)^2).
///
/// With S = H C H^T + diag(s)^2 the posterior has the mean C H^T S^-1 y and the covariance C - C H^T S^-1 H C; a sample
/// f of the prior becomes one of the posterior by Matheron's rule [Journel1978],
///   f + C H^T S^-1 (y - e - H f)   with e drawn anew.
/// S is dense: construction takes n products with C and n^3 / 3 operations, each sample then one product with C.
/// Deviations of 0 are exact observations, which the posterior honors to 1e-8 of the largest value. An exact
/// observation that follows from earlier ones (at the same place, or more than three in a triangle) is left out when
/// its value follows too, and an error when it does not.
class FieldConditioning
{
public:
  /// Returns C x for all columns of x, [V, K].
  using CovarianceProduct = std::function<Eigen::MatrixXd(const Eigen::Ref<const Eigen::MatrixXd>&)>;

  /// Assembles and factors S.
  /// @param covariance product with C; is kept, and must stay valid
  /// @param matrix H, [n, V]
  /// @param deviations s, [n], >= 0, in the units of the field
  /// @param memoryLimit bytes that S, its factor and blocks of columns may take: 32 n^2, and 32 V for each of the up to 64
  /// columns of a block
  /// @throws InvalidInput when shapes differ, a deviation is negative or not finite, the prior variance of an exact
  /// observation is 0, or the memory does not suffice (the text says how much is needed and how many observations fit);
  /// SolverFailure when S is not positive definite; Cancelled.
  FieldConditioning(CovarianceProduct covariance, const SparseRowMatrix& matrix, const Eigen::VectorXd& deviations,
    std::uint64_t memoryLimit, const Progress& progress = {});

  /// Posterior mean, [V, K], for each column of @p values, [n, K].
  /// @throws InvalidInput when exact observations contradict each other (the text names them by their row);
  /// SolverFailure when an exact observation is not met to 1e-8.
  Eigen::MatrixXd Mean(const Eigen::Ref<const Eigen::MatrixXd>& values) const;

  /// Posterior samples, [V, K], from samples of the prior, [V, K], by Matheron's rule.
  /// @param values y, [n, K]
  /// @param keys [K], of the observations' errors: number i of key k belongs to observation i of column k. They may be
  /// the keys of the samples, since another stream is drawn.
  /// @throws what Mean() throws
  Eigen::MatrixXd Sample(const Eigen::Ref<const Eigen::MatrixXd>& prior,
    const Eigen::Ref<const Eigen::MatrixXd>& values, const std::vector<NormalKey>& keys) const;

  /// Posterior variance, [V], from that of the prior, the diagonal of C, in n products with C.
  Eigen::VectorXd Variance(const Eigen::VectorXd& priorVariance, const Progress& progress = {}) const;

  /// Number of columns that one product with C takes within the memory limit, 1 to 64; worth keeping to for Sample().
  Eigen::Index ColumnsTogether() const { return this->Together; }

  /// Number of observations that follow from others and were left out.
  Index NumberOfDependent() const { return static_cast<Index>(this->Dependent.size()); }

private:
  void Factor(const Eigen::MatrixXd& full);
  void SplitRows(const Eigen::MatrixXd& full);
  void RequireConsistency(const Eigen::Ref<const Eigen::MatrixXd>& values) const;
  Eigen::MatrixXd Correct(Eigen::MatrixXd fields, const Eigen::Ref<const Eigen::MatrixXd>& values) const;
  Eigen::MatrixXd SolveSystem(Eigen::MatrixXd rightHandSides) const;

  CovarianceProduct Covariance;
  Eigen::Index Together;        ///< columns of one product with C
  SparseRowMatrix Matrix;       ///< rows of H that are kept, [m, V]
  Eigen::VectorXd Deviations;   ///< of all observations, [n]
  std::vector<Index> Kept;      ///< [m], observations in use
  std::vector<Index> Dependent; ///< exact observations that follow from others
  Eigen::MatrixXd Prediction;   ///< [dependent, m], their values from those of the kept ones
  Eigen::MatrixXd Root;         ///< [m, m], lower Cholesky factor of S
};

} // namespace surfsynth
