// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/NearestSamples.h"

#include "Core/Common/Errors.h"
#include "Core/Common/InstructionSet.h"
#include "Core/Common/Parallel.h"
#include "Core/Statistics/PairKernels.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// The samples of a row or column of tiles: 16 of 768 numbers each take 96 KB.
constexpr std::int64_t LargestTile = 16;
constexpr Eigen::Index NumbersOfBlock = 768;

struct Range
{
  std::int64_t Begin = 0;
  std::int64_t End = 0;
  std::int64_t Size() const { return this->End - this->Begin; }
};

/// The pairs (a, b), a < b, of samples of one range with those of the same or of a later range.
struct Tile
{
  Range Rows;
  Range Columns;
  bool IsDiagonal() const { return this->Rows.Begin == this->Columns.Begin; }
  std::int64_t FirstColumn(std::int64_t row) const { return this->IsDiagonal() ? row + 1 : this->Columns.Begin; }
  std::int64_t Pairs() const
  {
    return this->IsDiagonal() ? this->Rows.Size() * (this->Rows.Size() - 1) / 2
                              : this->Rows.Size() * this->Columns.Size();
  }
};

/// Tiles as large as leaves several for each thread; results do not depend on their size.
std::vector<Tile> TilesOf(std::int64_t samples)
{
  const int threads = MaximumThreads();
  const auto sides = static_cast<std::int64_t>(threads > 1 ? std::ceil(std::sqrt(8.0 * threads)) : 1.0);
  const std::int64_t size = std::clamp<std::int64_t>((samples + sides - 1) / sides, 1, LargestTile);
  const auto range = [&](std::int64_t begin) { return Range{ begin, std::min(begin + size, samples) }; };
  std::vector<Tile> tiles;
  for (std::int64_t row = 0; row < samples; row += size)
  {
    for (std::int64_t column = row; column < samples; column += size)
    {
      tiles.push_back({ range(row), range(column) });
    }
  }
  return tiles;
}

/// The sums of PartialDistance() of a tile, [Rows, Columns]; those of no pair stay 0.
RowMatrix SumTile(const SampleUnion& samples, const Tile& tile, SharedProgress& meter)
{
  const Eigen::Index points = samples.Weight.size();
  const Eigen::Index step = std::min(PointsOfBlock(samples), points);
  const Eigen::Index stride = step * samples.NumberOfComponents;
  std::vector<double> rows(static_cast<std::size_t>(tile.Rows.Size() * stride));
  std::vector<double> others(static_cast<std::size_t>(tile.IsDiagonal() ? 0 : tile.Columns.Size() * stride));
  const std::vector<double>& columns = tile.IsDiagonal() ? rows : others;
  RowMatrix sums = RowMatrix::Zero(tile.Rows.Size(), tile.Columns.Size());
  for (Eigen::Index begin = 0; begin < points; begin += step)
  {
    const Eigen::Index count = std::min(step, points - begin);
    const auto copy = [&](const Range& range, std::vector<double>& planes) {
      for (std::int64_t k = 0; k < range.Size(); ++k)
      {
        CopyPlanes(samples, range.Begin + k, begin, count, planes.data() + k * stride);
      }
    };
    copy(tile.Rows, rows);
    copy(others.empty() ? Range() : tile.Columns, others);
    for (std::int64_t a = tile.Rows.Begin; a < tile.Rows.End; ++a)
    {
      const double* row = rows.data() + (a - tile.Rows.Begin) * stride;
      for (std::int64_t b = tile.FirstColumn(a); b < tile.Columns.End; ++b)
      {
        sums(a - tile.Rows.Begin, b - tile.Columns.Begin) += PartialDistance(
          samples, row, columns.data() + (b - tile.Columns.Begin) * stride, begin, count);
      }
    }
    meter.Advance(tile.Pairs() * count);
  }
  return sums;
}

std::string DescribeSample(const SampleUnion& samples, std::int64_t sample)
{
  return samples.IsGenerated(sample) ? "generated sample " + std::to_string(sample)
                                     : "reference sample " + std::to_string(sample - samples.NumberOfGenerated);
}

/// Neighbours of the samples of a tile among its pairs: those of the rows, then those of the columns.
std::vector<Neighbors> NeighborsInTile(const SampleUnion& samples, const Tile& tile, const RowMatrix& sums)
{
  std::vector<Neighbors> found(static_cast<std::size_t>(tile.Rows.Size() + tile.Columns.Size()));
  for (std::int64_t a = tile.Rows.Begin; a < tile.Rows.End; ++a)
  {
    for (std::int64_t b = tile.FirstColumn(a); b < tile.Columns.End; ++b)
    {
      const double distance = FinishedDistance(samples.Distance, sums(a - tile.Rows.Begin, b - tile.Columns.Begin));
      if (!std::isfinite(distance))
      {
        throw InvalidInput("ComputeEnsembleMetrics: the distance of " + DescribeSample(samples, a) + " and " +
          DescribeSample(samples, b) + " is not finite; expected values below about 1e150.");
      }
      Neighbors& ofRow = found[static_cast<std::size_t>(a - tile.Rows.Begin)];
      Neighbors& ofColumn = found[static_cast<std::size_t>(tile.Rows.Size() + b - tile.Columns.Begin)];
      const bool same = samples.IsGenerated(a) == samples.IsGenerated(b);
      (same ? ofRow.InOwn : ofRow.InOther).Offer({ distance, b });
      (same ? ofColumn.InOwn : ofColumn.InOther).Offer({ distance, a });
    }
  }
  return found;
}

template <bool AllWeigh, typename Value>
void CopyPlane(const Value* values, Eigen::Index components, const double* weights, Eigen::Index count, double centroid,
  double* plane)
{
  for (Eigen::Index p = 0; p < count; ++p)
  {
    const double value = static_cast<double>(values[p * components]) - centroid;
    plane[p] = AllWeigh || weights[p] > 0.0 ? value : 0.0;
  }
}

using AddFunction = double (*)(const PairOfPlanes&);

/// The variant for CurrentInstructionSet().
AddFunction BestAdd()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? AddUpPairAvx512
    : set == InstructionSet::Avx2      ? AddUpPairAvx2
                                       : AddUpPairGeneric;
#else
  return AddUpPairGeneric;
#endif
}
} // namespace

Eigen::Index PointsOfBlock(const SampleUnion& samples)
{
  return std::max<Eigen::Index>(NumbersOfBlock / samples.NumberOfComponents, 16);
}

void CopyPlanes(const SampleUnion& samples, std::int64_t sample, Eigen::Index begin, Eigen::Index count, double* planes)
{
  const Eigen::Index components = samples.NumberOfComponents;
  const double* weights = samples.Weight.data() + begin;
  const auto copy = [&](const auto* values) {
    for (Eigen::Index c = 0; c < components; ++c)
    {
      const auto* first = values + begin * components + c;
      samples.AllWeigh
        ? CopyPlane<true>(first, components, weights, count, samples.Centroid(sample, c), planes + c * count)
        : CopyPlane<false>(first, components, weights, count, samples.Centroid(sample, c), planes + c * count);
    }
  };
  std::visit(copy, samples.Samples[static_cast<std::size_t>(sample)]);
}

double PartialDistance(
  const SampleUnion& samples, const double* a, const double* b, Eigen::Index begin, Eigen::Index count)
{
  const AddFunction add = BestAdd();
  PairOfPlanes pair;
  pair.A = a;
  pair.B = b;
  pair.Weights = samples.Weight.data() + begin;
  pair.Components = samples.NumberOfComponents;
  pair.Count = count;
  pair.Squared = samples.Distance == SampleDistance::RMS;
  return add(pair);
}

double FinishedDistance(SampleDistance distance, double sum)
{
  return distance == SampleDistance::RMS ? std::sqrt(sum) : sum;
}

std::vector<Neighbors> FindNeighbors(const SampleUnion& samples, SharedProgress& meter)
{
  std::vector<Neighbors> neighbors(samples.Samples.size());
  std::mutex mutex;
  const std::vector<Tile> tiles = TilesOf(samples.Size());
  const auto search = [&](std::int64_t k) {
    const Tile& tile = tiles[static_cast<std::size_t>(k)];
    const auto found = NeighborsInTile(samples, tile, SumTile(samples, tile, meter));
    const std::lock_guard<std::mutex> lock(mutex);
    const auto offer = [&](const Range& range, std::int64_t first) {
      for (std::int64_t s = 0; s < range.Size(); ++s)
      {
        neighbors[static_cast<std::size_t>(range.Begin + s)].Offer(found[static_cast<std::size_t>(first + s)]);
      }
    };
    offer(tile.Rows, 0);
    offer(tile.Columns, tile.Rows.Size());
  };
  ParallelTasks(static_cast<std::int64_t>(tiles.size()), search, [&] { meter.Advance(0); });
  return neighbors;
}

} // namespace surfsynth
