// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Nearest neighbours of every sample of two ensembles. Private to the core.
#pragma once

#include "Core/Common/SharedProgress.h"
#include "Core/Statistics/EnsembleMetrics.h"

#include <limits>

namespace surfsynth
{

/// Row-major float64 matrix.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Both ensembles, the generated samples first, with the parameters of their distance.
struct SampleUnion
{
  std::vector<SampleValues> Samples;                ///< [N + M]
  std::int64_t NumberOfGenerated = 0;               ///< N
  Eigen::Index NumberOfComponents = 3;              ///< C
  Eigen::VectorXd Weight;                           ///< [V], masses divided by their sum
  bool AllWeigh = false;                            ///< true when no weight is 0
  RowMatrix Centroid;                               ///< [N + M, C], subtracted from the values
  SampleDistance Distance = SampleDistance::MeanL2; ///< distance of two samples

  /// Number of samples, N + M.
  std::int64_t Size() const { return static_cast<std::int64_t>(this->Samples.size()); }
  /// True when the sample of this index is a generated one.
  bool IsGenerated(std::int64_t sample) const { return sample < this->NumberOfGenerated; }
};

/// Number of points to process at a time, so that the values of a tile of samples stay in the cache.
Eigen::Index PointsOfBlock(const SampleUnion& samples);

/// Fills planes[c * count + p] with component c of point begin + p of a sample, less its centroid; 0 at points without
/// mass, whose values are not read.
void CopyPlanes(
  const SampleUnion& samples, std::int64_t sample, Eigen::Index begin, Eigen::Index count, double* planes);

/// Contribution of some points to the distance of two samples, from the planes @p a and @p b of CopyPlanes().
double PartialDistance(
  const SampleUnion& samples, const double* a, const double* b, Eigen::Index begin, Eigen::Index count);
/// Distance of two samples from the sum of all contributions.
double FinishedDistance(SampleDistance distance, double sum);

/// A nearest sample and its distance; of several at the smallest distance the first one.
struct Neighbor
{
  double Distance = std::numeric_limits<double>::infinity(); ///< infinity before the first Offer()
  std::int64_t Sample = -1;                                  ///< index in the union; -1 before the first Offer()

  /// True when @p other is nearer, or at the same distance with a lower index.
  bool IsBeyond(const Neighbor& other) const
  {
    return other.Distance < this->Distance || (other.Distance == this->Distance && other.Sample < this->Sample);
  }
  /// Takes @p other when this neighbour is beyond it.
  /// Takes @p other when this neighbour is beyond it.
  void Offer(const Neighbor& other)
  {
    if (this->IsBeyond(other))
    {
      *this = other;
    }
  }
};

/// The nearest samples of one sample in both ensembles.
struct Neighbors
{
  Neighbor InOwn;   ///< in the same ensemble; Sample is -1 when there is no other
  Neighbor InOther; ///< in the other ensemble

  /// Takes the nearer ones of these neighbours and @p others.
  void Offer(const Neighbors& others)
  {
    this->InOwn.Offer(others.InOwn);
    this->InOther.Offer(others.InOther);
  }
};

/// Finds the neighbours of every sample, in order. Adds (N + M) (N + M - 1) / 2 times V to the meter.
/// @throws InvalidInput when a distance is not finite; Cancelled
std::vector<Neighbors> FindNeighbors(const SampleUnion& samples, SharedProgress& meter);

} // namespace surfsynth
