// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Metrics of two ensembles of shapes or signals on one triangulation: [Kuai2026], section 5 and appendix D, after
/// [Achlioptas2018] (coverage, minimum matching distance), [LopezPaz2017] (two-sample tests by the nearest neighbour)
/// and [Yang2019] (all of them for shapes).
#pragma once

#include "Core/Common/Progress.h"

#include <Eigen/Core>

#include <cstdint>
#include <variant>
#include <vector>

namespace surfsynth
{

/// Values of one sample, [V, C], point after point, float32 or float64; memory of the caller.
using SampleValues = std::variant<const float*, const double*>;

/// Two ensembles of samples on one triangulation.
struct EnsemblePair
{
  std::vector<SampleValues> Generated; ///< N samples
  std::vector<SampleValues> Reference; ///< M samples
  int NumberOfComponents = 3;          ///< C, at least 1
};

/// Distance of two samples a and b with masses m of the points; world units, or those of the signal.
enum class SampleDistance
{
  MeanL2, ///< sum_i m_i || a_i - b_i || / sum_i m_i: that of [Kuai2026]
  RMS     ///< sqrt(sum_i m_i || a_i - b_i ||^2 / sum_i m_i): weighs outliers more
};

/// Options of the comparison.
struct EnsembleMetricsOptions
{
  SampleDistance Distance = SampleDistance::MeanL2; ///< distance of two samples
  /// Subtracts from each sample its mean value, weighted by mass: compares shapes up to translation.
  bool RemoveCentroid = false;
};

/// The metrics. Of several nearest samples at the same distance the one with the lowest index counts, generated before
/// reference.
struct EnsembleMetrics
{
  /// Minimum matching distance of [Kuai2026]: the mean, over the generated samples, of the distance to the nearest
  /// reference. At least 0; low for faithful samples, even if they are all the same.
  double MMD = 0.0;
  /// Minimum matching distance of [Achlioptas2018]: the mean, over the references, of the distance to the nearest
  /// generated sample. At least 0; low when each reference has a generated sample near it.
  double ReverseMMD = 0.0;
  /// Coverage: the fraction of the references that are nearest to at least one generated sample, in (0, 1].
  double COV = 0.0;
  /// Leave-one-out accuracy, in [0, 1], of telling generated samples and references apart by the nearest other sample
  /// of the union: about 0.5 for equal distributions, 1 for separate ones, 0 when each reference has been copied.
  double OneNearestNeighborAccuracy = 0.0;
  /// Distance of the pointwise means of both ensembles ("Test Error" of table 2 of [Kuai2026]).
  double MeanError = 0.0;
  /// Mean distance of a generated sample to the nearest other one; 0 for a single sample.
  double GeneratedSpacing = 0.0;
  /// Mean distance of a reference to the nearest other one; 0 for a single one. An MMD much below it shows that samples
  /// are copies of references.
  double ReferenceSpacing = 0.0;

  std::vector<std::int64_t> NearestReference; ///< [N], index of the reference nearest to each generated sample
  std::vector<double> DistanceToReference;    ///< [N], distance to it
};

/// Compares two ensembles. O((N + M)^2 V C) time, O(N + M) memory beside the values, which are read in place: single
/// precision is widened, all arithmetic is float64. The same bits for every number of threads.
/// @param mass [V], at least 0, with a sum above 0; values at points of mass 0 count for nothing and may be anything.
/// @throws InvalidInput for an empty ensemble, masses as above not given, a value that is not finite, or values so far
/// apart that their distance is not; Cancelled
EnsembleMetrics ComputeEnsembleMetrics(const EnsemblePair& ensembles, const Eigen::VectorXd& mass,
  const EnsembleMetricsOptions& options = {}, const Progress& progress = {});

} // namespace surfsynth
