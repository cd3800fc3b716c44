// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/EnsembleStatistics.h"

#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/Quantiles.h"
#include "Core/Common/SharedProgress.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>

namespace surfsynth
{

namespace
{
/// Values of a tile of all samples, [N, columns of the tile].
using TileValues = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Numbers in a tile, and in the matrices of inner products that are summed up side by side.
constexpr std::int64_t TileSize = 1 << 17;
constexpr std::int64_t GramSize = 1 << 26;
/// Smallest variance of a mode, as a fraction of the largest.
constexpr double SmallestVariance = 1e-12;

[[noreturn]] void RefuseStatistics(const std::string& text)
{
  throw InvalidInput("ComputeEnsembleStatistics: " + text);
}

/// The samples, cut into tiles of columns. The tiles depend on the samples only, so that the results do not depend on the
/// number of threads.
struct TiledSamples
{
  TiledSamples(const std::vector<SampleValues>& samples, std::int64_t columns, int components)
    : Samples(samples)
    , Rows(static_cast<std::int64_t>(samples.size()))
    , Columns(columns)
    , Components(components)
    , Step(std::clamp<std::int64_t>(TileSize / std::max<std::int64_t>(this->Rows, 1), 16, 4096))
    , Tiles((columns + this->Step - 1) / this->Step)
  {}

  std::int64_t Begin(std::int64_t tile) const { return tile * this->Step; }
  std::int64_t Width(std::int64_t tile) const { return std::min(this->Step, this->Columns - this->Begin(tile)); }

  /// Reads a tile in double precision.
  void Read(std::int64_t tile, TileValues& values) const
  {
    const std::int64_t begin = this->Begin(tile), width = this->Width(tile);
    values.resize(this->Rows, width);
    for (std::int64_t sample = 0; sample < this->Rows; ++sample)
    {
      std::visit([&](const auto* data) { std::copy_n(data + begin, width, &values(sample, 0)); },
        this->Samples[static_cast<std::size_t>(sample)]);
    }
  }

  const std::vector<SampleValues>& Samples;
  std::int64_t Rows, Columns;
  int Components;
  std::int64_t Step, Tiles;
};

/// First value that is not finite, in order of samples.
class NonFiniteValue
{
public:
  /// Looks at a tile; true when all of its values are finite.
  bool Inspect(const TiledSamples& samples, std::int64_t tile, const TileValues& values)
  {
    if (values.allFinite())
    {
      return true;
    }
    std::lock_guard<std::mutex> lock(this->Mutex);
    for (Eigen::Index sample = 0; sample < values.rows(); ++sample)
    {
      for (Eigen::Index column = 0; column < values.cols(); ++column)
      {
        const std::int64_t point = (samples.Begin(tile) + column) / samples.Components;
        if (!std::isfinite(values(sample, column)) && std::pair(std::int64_t(sample), point) < this->First)
        {
          this->First = { sample, point };
        }
      }
    }
    return false;
  }
  /// @throws InvalidInput when there is one
  void Refuse() const
  {
    if (this->First.first != std::numeric_limits<std::int64_t>::max())
    {
      RefuseStatistics("sample " + std::to_string(this->First.first) + " has a value that is not finite at point " +
        std::to_string(this->First.second) + "; expected finite values at all points.");
    }
  }

private:
  std::mutex Mutex;
  std::pair<std::int64_t, std::int64_t> First{ std::numeric_limits<std::int64_t>::max(), 0 };
};

/// Quantiles of each column.
void FillQuantiles(
  const TileValues& values, const std::vector<double>& probabilities, std::int64_t begin, Eigen::MatrixXd& quantiles)
{
  Eigen::VectorXd sorted(values.rows());
  for (Eigen::Index column = 0; column < values.cols(); ++column)
  {
    sorted = values.col(column);
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t q = 0; q < probabilities.size(); ++q)
    {
      quantiles(begin + column, static_cast<Eigen::Index>(q)) = QuantileOfSorted(
        sorted.data(), sorted.size(), probabilities[q]);
    }
  }
}

void RequireStatisticsOptions(
  const std::vector<SampleValues>& samples, int components, const EnsembleStatisticsOptions& options)
{
  if (samples.size() < 2)
  {
    RefuseStatistics("the ensemble has " + std::to_string(samples.size()) +
      (samples.size() == 1 ? " sample" : " samples") + "; expected at least 2, for a standard deviation.");
  }
  if (components < 1 || options.NumberOfModes < -1)
  {
    RefuseStatistics("found " + std::to_string(components) + " components and " +
      std::to_string(options.NumberOfModes) + " modes; expected at least 1 component, and at least 0 modes or -1.");
  }
  for (const double probability : options.Quantiles)
  {
    if (!(probability >= 0.0 && probability <= 1.0))
    {
      RefuseStatistics(
        "the probability of a quantile is " + FormatNumber(probability) + "; expected a number in [0, 1].");
    }
  }
}

/// Refuses results that are larger than the memory, before the work.
void RequireStatisticsMemory(std::int64_t samples, std::int64_t columns, std::int64_t modes, std::size_t quantiles)
{
  const double vectors = 3.0 + static_cast<double>(quantiles) + static_cast<double>(modes);
  const double grams = modes > 0 ? 4.0 * static_cast<double>(samples) * static_cast<double>(samples) : 0.0;
  const double bytes = 8.0 * (vectors * static_cast<double>(columns) + grams);
  const double available = static_cast<double>(AvailableMemory());
  if (bytes > available)
  {
    RefuseStatistics(std::to_string(samples) + " samples of " + std::to_string(columns) + " values with " +
      std::to_string(modes) + " modes and " + std::to_string(quantiles) + " quantiles need " +
      FormatNumber(std::ceil(bytes / 1048576.0)) + " MiB and " + FormatNumber(std::floor(available / 1048576.0)) +
      " MiB are available; expected fewer modes, quantiles or samples.");
  }
}

/// Moments, quantiles and, where @p gram is not null, inner products of the deviations of the samples.
void FirstPass(const TiledSamples& samples, const std::vector<double>& quantiles, EnsembleStatistics& result,
  Eigen::MatrixXd* gram, SharedProgress& meter)
{
  const std::int64_t slots = gram
    ? std::clamp<std::int64_t>(GramSize / (samples.Rows * samples.Rows), 1, std::min<std::int64_t>(16, samples.Tiles))
    : samples.Tiles;
  std::vector<Eigen::MatrixXd> grams(gram ? static_cast<std::size_t>(slots) : 0);
  NonFiniteValue nonFinite;
  ParallelTasks(
    slots,
    [&](std::int64_t slot) {
      TileValues values;
      for (std::int64_t tile = slot; tile < samples.Tiles; tile += slots)
      {
        samples.Read(tile, values);
        meter.Advance(samples.Width(tile));
        if (!nonFinite.Inspect(samples, tile, values))
        {
          continue;
        }
        const std::int64_t begin = samples.Begin(tile), width = samples.Width(tile);
        FillQuantiles(values, quantiles, begin, result.Quantiles);
        const Eigen::RowVectorXd first = values.row(0); // differences keep the digits of values far from 0
        values.rowwise() -= first;
        const Eigen::RowVectorXd mean = values.colwise().mean();
        values.rowwise() -= mean;
        result.Mean.segment(begin, width) = first + mean;
        result.StandardDeviation.segment(
          begin, width) = (values.colwise().squaredNorm() / static_cast<double>(samples.Rows - 1)).cwiseSqrt();
        if (gram)
        {
          Eigen::MatrixXd& sum = grams[static_cast<std::size_t>(slot)];
          sum = sum.size() > 0 ? std::move(sum) : Eigen::MatrixXd::Zero(samples.Rows, samples.Rows).eval();
          sum.selfadjointView<Eigen::Lower>().rankUpdate(values);
        }
      }
    },
    [&] { meter.Advance(0); });
  nonFinite.Refuse();
  for (const Eigen::MatrixXd& part : grams)
  {
    *gram += part;
  }
}

/// Variances and coefficients of the modes, from the inner products of the deviations.
void SolveModes(const Eigen::MatrixXd& gram, std::int64_t modes, EnsembleStatistics& result)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram); // reads the lower half
  if (solver.info() != Eigen::Success)
  {
    throw SolverFailure("ComputeEnsembleStatistics: the eigenvalues of the inner products of the samples did not "
                        "converge; expected convergence for finite values.");
  }
  const Eigen::Index size = gram.rows();
  const double divisor = static_cast<double>(size - 1);
  const Eigen::VectorXd& values = solver.eigenvalues(); // ascending
  Eigen::Index kept = 0;
  while (kept < modes && values[size - 1 - kept] > 0.0 && values[size - 1 - kept] > SmallestVariance * values[size - 1])
  {
    ++kept;
  }
  result.Variances = values.reverse().head(kept) / divisor;
  result.Coefficients = solver.eigenvectors().rowwise().reverse().leftCols(kept) * std::sqrt(divisor);
  for (Eigen::Index k = 0; k < kept; ++k)
  {
    Eigen::Index largest = 0;
    result.Coefficients.col(k).cwiseAbs().maxCoeff(&largest);
    if (result.Coefficients(largest, k) < 0.0)
    {
      result.Coefficients.col(k) = -result.Coefficients.col(k);
    }
  }
}

/// Modes as sums of the samples' deviations.
void SecondPass(const TiledSamples& samples, EnsembleStatistics& result, SharedProgress& meter)
{
  result.Modes.resize(samples.Columns, result.Variances.size());
  const Eigen::MatrixXd factors = result.Coefficients / static_cast<double>(samples.Rows - 1);
  ParallelTasks(
    samples.Tiles,
    [&](std::int64_t tile) {
      TileValues values;
      samples.Read(tile, values);
      values.rowwise() -= result.Mean.segment(samples.Begin(tile), samples.Width(tile)).transpose();
      result.Modes.middleRows(samples.Begin(tile), samples.Width(tile)).noalias() = values.transpose() * factors;
      meter.Advance(samples.Width(tile));
    },
    [&] { meter.Advance(0); });
}
} // namespace

EnsembleStatistics ComputeEnsembleStatistics(const std::vector<SampleValues>& samples, std::int64_t points,
  int components, const EnsembleStatisticsOptions& options, const Progress& progress)
{
  RequireStatisticsOptions(samples, components, options);
  if (points < 1)
  {
    RefuseStatistics("the samples have no points; expected at least 1.");
  }
  const TiledSamples tiles(samples, points * components, components);
  const std::int64_t most = std::min<std::int64_t>(tiles.Rows - 1, tiles.Columns);
  const std::int64_t modes = options.NumberOfModes < 0 ? most : std::min<std::int64_t>(options.NumberOfModes, most);
  RequireStatisticsMemory(tiles.Rows, tiles.Columns, modes, options.Quantiles.size());
  SharedProgress meter(progress, std::max<std::int64_t>((modes > 0 ? 2 : 1) * tiles.Columns, 1));
  Report(progress, 0.0);
  EnsembleStatistics result;
  result.Mean.resize(tiles.Columns);
  result.StandardDeviation.resize(tiles.Columns);
  result.Quantiles.resize(tiles.Columns, static_cast<Eigen::Index>(options.Quantiles.size()));
  Eigen::MatrixXd gram;
  if (modes > 0)
  {
    gram = Eigen::MatrixXd::Zero(tiles.Rows, tiles.Rows);
  }
  FirstPass(tiles, options.Quantiles, result, modes > 0 ? &gram : nullptr, meter);
  if (!result.Mean.allFinite() || !result.StandardDeviation.allFinite() || !std::isfinite(gram.sum()))
  {
    RefuseStatistics("a sum of squared values is not finite; expected values below about 1e150.");
  }
  if (modes > 0)
  {
    result.TotalVariance = result.StandardDeviation.squaredNorm();
    SolveModes(gram, modes, result);
    SecondPass(tiles, result, meter);
  }
  Report(progress, 1.0);
  return result;
}

void RunningMoments::Add(const SampleValues& sample, std::int64_t size, int components)
{
  if (this->Samples == 0)
  {
    this->Mean = Eigen::VectorXd::Zero(size);
    this->SquaredDeviations = Eigen::VectorXd::Zero(size);
  }
  if (size != this->Mean.size())
  {
    RefuseStatistics("sample " + std::to_string(this->Samples) + " has " + std::to_string(size) +
      " values and the first one " + std::to_string(this->Mean.size()) + "; expected the same number.");
  }
  const double count = static_cast<double>(++this->Samples);
  std::visit(
    [&](const auto* data) {
      for (std::int64_t k = 0; k < size; ++k)
      {
        const double value = static_cast<double>(data[k]);
        if (!std::isfinite(value))
        {
          RefuseStatistics("sample " + std::to_string(this->Samples - 1) + " has a value that is not finite at point " +
            std::to_string(k / components) + "; expected finite values at all points.");
        }
        const double difference = value - this->Mean[k];
        this->Mean[k] += difference / count;
        this->SquaredDeviations[k] += difference * (value - this->Mean[k]);
      }
    },
    sample);
}

EnsembleStatistics RunningMoments::Finish() const
{
  RequireStatisticsOptions(
    std::vector<SampleValues>(static_cast<std::size_t>(std::min<std::int64_t>(this->Samples, 2))), 1, {});
  EnsembleStatistics result;
  result.Mean = this->Mean;
  result.StandardDeviation = (this->SquaredDeviations / static_cast<double>(this->Samples - 1)).cwiseSqrt();
  if (!result.Mean.allFinite() || !result.StandardDeviation.allFinite())
  {
    RefuseStatistics("a sum of squared values is not finite; expected values below about 1e150.");
  }
  return result;
}

} // namespace surfsynth
