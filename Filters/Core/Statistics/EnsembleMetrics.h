// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// How alike two ensembles of shapes or signals on one triangulation are: section 5 and appendix D of "Matérn Noise
/// for Triangulation-Agnostic Flow Matching on Meshes", after Achlioptas et al. (2018), Lopez-Paz and Oquab (2017) and
/// Yang et al. (2019).
#pragma once

#include "Core/Common/Progress.h"

#include <Eigen/Core>

#include <cstdint>
#include <variant>
#include <vector>

namespace surfsynth
{

/// The values of one sample, [V, C], point after point, float32 or float64; they belong to the caller.
using SampleValues = std::variant<const float*, const double*>;

/// What two ensembles have in common, and their samples.
struct EnsemblePair
{
  std::vector<SampleValues> Generated; ///< N samples
  std::vector<SampleValues> Reference; ///< M samples
  int NumberOfComponents = 3;          ///< C, at least 1
};

/// The distance of two samples a and b with masses m of the points; world units, or those of the signal.
enum class SampleDistance
{
  MeanL2, ///< sum_i m_i || a_i - b_i || / sum_i m_i: the paper's
  RMS     ///< sqrt(sum_i m_i || a_i - b_i ||^2 / sum_i m_i): weighs outliers more
};

struct EnsembleMetricsOptions
{
  SampleDistance Distance = SampleDistance::MeanL2;
  /// Compare each sample less its mean value, weighted by mass: for shapes, up to translation.
  bool RemoveCentroid = false;
};

/// The metrics. Of several nearest samples at the same distance the one with the lowest index counts, generated before
/// reference.
struct EnsembleMetrics
{
  /// Minimum matching distance as the paper words it: the mean, over the generated samples, of the distance to the
  /// nearest reference. At least 0; low where what is generated is faithful, even if it is always the same.
  double MMD = 0.0;
  /// Minimum matching distance as Achlioptas et al. word it: the mean, over the references, of the distance to the
  /// nearest generated sample. At least 0; low where all of the references are reached.
  double ReverseMMD = 0.0;
  /// Coverage: the fraction of the references that are nearest to at least one generated sample, in (0, 1].
  double COV = 0.0;
  /// Leave-one-out accuracy, in [0, 1], of telling generated samples and references apart by the nearest other sample
  /// of the union: about 0.5 for equal distributions, 1 for separate ones, 0 where each reference has been copied.
  double OneNearestNeighbourAccuracy = 0.0;
  /// The distance of the pointwise means of both ensembles ("Test Error" of table 2).
  double MeanError = 0.0;
  /// The mean distance of a generated sample to the nearest other one; 0 when there is one only. MMD is to be seen
  /// beside these two: much below the second one, samples are copies of references.
  double GeneratedSpacing = 0.0;
  /// The same among the references.
  double ReferenceSpacing = 0.0;

  std::vector<std::int64_t> NearestReference; ///< [N], for each generated sample
  std::vector<double> DistanceToReference;    ///< [N], how far that is
};

/// Compares two ensembles. O((N + M)^2 V C) time, O(N + M) memory beside the values, which are read in place: single
/// precision is widened, all arithmetic is float64. The same bits for every number of threads.
/// @param mass [V], at least 0, with a sum above 0; values at points of mass 0 count for nothing and may be anything.
/// @throws InvalidInput for an empty ensemble, masses as above not given, a value that is not finite, or values so far
/// apart that their distance is not; Cancelled
EnsembleMetrics ComputeEnsembleMetrics(const EnsemblePair& ensembles, const Eigen::VectorXd& mass,
  const EnsembleMetricsOptions& options = {}, const Progress& progress = {});

} // namespace surfsynth
