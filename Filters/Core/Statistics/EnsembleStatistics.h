// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Statistics of an ensemble of shapes or signals on one triangulation: pointwise moments and quantiles, and principal
/// modes, which make a statistical shape model [Cootes1995].
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Statistics/EnsembleMetrics.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Options of ComputeEnsembleStatistics().
struct EnsembleStatisticsOptions
{
  std::vector<double> Quantiles; ///< probabilities in [0, 1]; default none
  int NumberOfModes = 0;         ///< at least 0, or -1 for all; default 0
};

/// Statistics of N samples. Values of points are vectors of V C numbers, point after point.
struct EnsembleStatistics
{
  Eigen::VectorXd Mean;              ///< [V C], arithmetic mean
  Eigen::VectorXd StandardDeviation; ///< [V C], with the divisor N - 1
  Eigen::MatrixXd Quantiles;         ///< [V C, Q], linear between order statistics: type 7 of [Hyndman1996]
  /// [V C, K], principal modes, each an eigenvector of the covariance times its standard deviation, in descending order
  /// of variance: mean plus mode is a shape one standard deviation away. The sample with the largest coefficient of a
  /// mode has a positive one.
  Eigen::MatrixXd Modes;
  Eigen::VectorXd Variances; ///< [K], eigenvalues of the covariance: squared norms of the modes
  double TotalVariance = 0;  ///< trace of the covariance; 0 when no modes are asked for
  /// [N, K], coefficients of the samples in standard deviations: mean zero, variance one.
  Eigen::MatrixXd Coefficients;
};

/// Computes statistics of samples [V, C] in place, by tiles of points. Modes follow from the inner products of the samples
/// (method of snapshots, [Sirovich1987]): their relative error is about 1e-16 times the ratio of the largest variance to
/// theirs, and modes with less than 1e-12 of the largest variance are left out. O(N^2 V C) time with modes, else
/// O(N log(N) V C); O(V C (2 + Q + K) + N^2) memory. The same bits for every number of threads.
/// @param points V, at least 1
/// @param components C, at least 1
/// @throws InvalidInput for fewer than 2 samples, options out of range, values that are not finite (with the first sample
/// and point) or whose squares overflow, and results for which there is not enough memory; SolverFailure; Cancelled
EnsembleStatistics ComputeEnsembleStatistics(const std::vector<SampleValues>& samples, std::int64_t points,
  int components, const EnsembleStatisticsOptions& options = {}, const Progress& progress = {});

/// Mean and standard deviation of samples that come one after the other, by the updates of [Welford1962]: O(V C) memory for
/// any number of samples.
class RunningMoments
{
public:
  /// Adds a sample of @p size numbers, that of the first one.
  /// @throws InvalidInput for another size, or a value that is not finite
  void Add(const SampleValues& sample, std::int64_t size, int components);
  /// Number of samples so far.
  std::int64_t Count() const { return this->Samples; }
  /// Returns mean and standard deviation. @throws InvalidInput for fewer than 2 samples
  EnsembleStatistics Finish() const;

private:
  std::int64_t Samples = 0;
  Eigen::VectorXd Mean;
  Eigen::VectorXd SquaredDeviations;
};

} // namespace surfsynth
