// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The nearest neighbours of every sample of two ensembles. Private to the core.
#pragma once

#include "Core/Common/SharedProgress.h"
#include "Core/Statistics/EnsembleMetrics.h"

#include <limits>

namespace surfsynth
{

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Both ensembles, the generated samples first, with what their distance depends on.
struct SampleUnion
{
  std::vector<SampleValues> Samples; ///< N + M
  std::int64_t NumberOfGenerated = 0;
  Eigen::Index NumberOfComponents = 3;
  Eigen::VectorXd Weight; ///< [V], masses divided by their sum
  bool AllWeigh = false;  ///< no weight is 0
  RowMatrix Centroid;     ///< [N + M, C], what is taken off the values
  SampleDistance Distance = SampleDistance::MeanL2;

  std::int64_t Size() const { return static_cast<std::int64_t>(this->Samples.size()); }
  bool IsGenerated(std::int64_t sample) const { return sample < this->NumberOfGenerated; }
};

/// Points that are taken at a time, so that as many of a tile of samples stay in the cache.
Eigen::Index PointsOfBlock(const SampleUnion& samples);

/// Fills planes[c * count + p] with component c of point begin + p of a sample, less its centroid; 0 at points without
/// mass, whose values are not read.
void CopyPlanes(
  const SampleUnion& samples, std::int64_t sample, Eigen::Index begin, Eigen::Index count, double* planes);

/// What some points, as CopyPlanes() leaves them, add to the distance of two samples; FinishedDistance() of the sum is
/// the distance.
double PartialDistance(
  const SampleUnion& samples, const double* a, const double* b, Eigen::Index begin, Eigen::Index count);
double FinishedDistance(SampleDistance distance, double sum);

/// A sample and how far it is; the first one of those at the least distance.
struct Neighbour
{
  double Distance = std::numeric_limits<double>::infinity();
  std::int64_t Sample = -1;

  bool IsBeyond(const Neighbour& other) const
  {
    return other.Distance < this->Distance || (other.Distance == this->Distance && other.Sample < this->Sample);
  }
  void Offer(const Neighbour& other)
  {
    if (this->IsBeyond(other))
    {
      *this = other;
    }
  }
};

struct Neighbours
{
  Neighbour InOwn;   ///< of the same ensemble; Sample is -1 when there is no other
  Neighbour InOther; ///< of the other one

  void Offer(const Neighbours& others)
  {
    this->InOwn.Offer(others.InOwn);
    this->InOther.Offer(others.InOther);
  }
};

/// The neighbours of every sample, in order. Adds (N + M) (N + M - 1) / 2 times V to the meter.
/// @throws InvalidInput when a distance is not finite; Cancelled
std::vector<Neighbours> FindNeighbours(const SampleUnion& samples, SharedProgress& meter);

} // namespace surfsynth
