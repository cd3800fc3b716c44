// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/Aggregation.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr double StrengthFraction = 0.33;
constexpr double DominatedFraction = 0.1;
constexpr double JacobiDamping = 2.0 / 3.0;
constexpr Index NoAggregate = -1;
constexpr Index Dominated = -2;

/// Strong entries of the scaled matrix.
class Strength
{
public:
  explicit Strength(const AggregationInput& input)
    : Matrix(input.Matrix)
    , Root(input.Root)
    , Largest(static_cast<std::size_t>(input.Matrix.Rows))
    , Smooth(input.Smooth)
  {
    ParallelFor(this->Matrix.Rows, FineGrain, [this](std::int64_t begin, std::int64_t end) {
      for (auto row = static_cast<Index>(begin); row < static_cast<Index>(end); ++row)
      {
        this->Measure(row);
      }
    });
  }

  /// Entry k, of row @p row, of the scaled matrix.
  double Entry(Index row, Index k) const
  {
    const double value = this->Matrix.Value.data()[k];
    return this->Root.size() > 0 ? value / (this->Root.data()[row] * this->Root.data()[this->Matrix.Column.data()[k]])
                                 : value;
  }
  /// True when entry k of row @p row, with the scaled value @p value, is strong.
  bool IsStrong(Index row, Index k, double value) const
  {
    const Index column = this->Matrix.Column.data()[k];
    return column != row && value < 0.0 &&
      -value >=
      StrengthFraction * static_cast<double>(std::min(this->Largest.data()[row], this->Largest.data()[column]));
  }
  /// True when the equation of @p row is dominated by its diagonal.
  bool IsDominated(Index row) const { return this->Largest.data()[row] == std::numeric_limits<float>::infinity(); }

private:
  void Measure(Index row)
  {
    double largest = 0.0;
    double negative = 0.0;
    for (Index k = this->Matrix.Start.data()[row]; k < this->Matrix.Start.data()[row + 1]; ++k)
    {
      const Index column = this->Matrix.Column.data()[k];
      const double value = column == row ? 0.0 : this->Entry(row, k);
      largest = std::max(largest, -value);
      negative += std::abs(value) * this->Smooth.data()[column];
    }
    const bool dominated = negative <= DominatedFraction * this->Smooth.data()[row];
    this->Largest.data()[row] = dominated ? std::numeric_limits<float>::infinity() : static_cast<float>(largest);
  }

  const SparseRows& Matrix;
  const LargeArray<double>& Root;
  LargeArray<float> Largest; ///< [V], largest negative entry off the diagonal; infinite for a dominated row
  const LargeArray<double>& Smooth;
};

/// Greedy aggregation in three passes.
class Aggregator
{
public:
  Aggregator(const SparseRows& matrix, const Strength& strength)
    : Matrix(matrix)
    , Strong(strength)
    , Of(static_cast<std::size_t>(matrix.Rows))
  {
    for (Index row = 0; row < matrix.Rows; ++row)
    {
      this->Of.data()[row] = strength.IsDominated(row) ? Dominated : NoAggregate;
    }
  }
  LargeArray<Index> Run(Index& count, const Progress& progress)
  {
    this->Each(SubProgress(progress, 0.0, 0.5), [this](Index row) { this->BeginWhereFree(row); });
    const Index fromFree = this->Count;
    this->Each(SubProgress(progress, 0.5, 0.9), [this, fromFree](Index row) { this->Join(row, fromFree); });
    this->Each(SubProgress(progress, 0.9, 1.0), [this](Index row) { this->BeginWithTheRest(row); });
    for (Index row = 0; row < this->Matrix.Rows; ++row)
    {
      Index& of = this->Of.data()[row];
      of = of < Dominated ? Joined - of : of;
    }
    count = this->Count;
    return std::move(this->Of);
  }

private:
  /// Marks those that joined an aggregate a in the second pass as Joined - a until the end, so that others do not join
  /// it through them.
  static constexpr Index Joined = -3;

  template <typename Pass>
  void Each(const Progress& progress, const Pass& pass)
  {
    constexpr Index ReportEvery = Index(1) << 18;
    for (Index row = 0; row < this->Matrix.Rows; ++row)
    {
      if (this->Of.data()[row] == NoAggregate)
      {
        pass(row);
      }
      if (row % ReportEvery == 0)
      {
        Report(progress, static_cast<double>(row) / this->Matrix.Rows);
      }
    }
  }
  template <typename Body>
  void StrongNeighbors(Index row, const Body& body) const
  {
    for (Index k = this->Matrix.Start.data()[row]; k < this->Matrix.Start.data()[row + 1]; ++k)
    {
      const double value = this->Strong.Entry(row, k);
      if (this->Strong.IsStrong(row, k, value))
      {
        body(this->Matrix.Column.data()[k], -value);
      }
    }
  }
  void BeginWhereFree(Index row)
  {
    bool free = true;
    this->StrongNeighbors(row, [&](Index neighbor, double) { free = free && this->Of.data()[neighbor] < 0; });
    if (free)
    {
      this->BeginWithTheRest(row);
    }
  }
  void Join(Index row, Index fromFree)
  {
    double strongest = 0.0;
    Index aggregate = NoAggregate;
    this->StrongNeighbors(row, [&](Index neighbor, double strength) {
      const Index of = this->Of.data()[neighbor];
      if (of >= 0 && of < fromFree && strength > strongest)
      {
        strongest = strength;
        aggregate = of;
      }
    });
    if (aggregate != NoAggregate)
    {
      this->Of.data()[row] = Joined - aggregate;
    }
  }
  void BeginWithTheRest(Index row)
  {
    this->Of.data()[row] = this->Count;
    this->StrongNeighbors(row, [&](Index neighbor, double) {
      Index& of = this->Of.data()[neighbor];
      of = of == NoAggregate ? this->Count : of;
    });
    ++this->Count;
  }

  const SparseRows& Matrix;
  const Strength& Strong;
  LargeArray<Index> Of;
  Index Count = 0;
};

/// Entries of one row of the interpolation, weights before the scaling of aggregates. Aggregates of a row are few.
class InterpolationRow
{
public:
  InterpolationRow(const AggregationInput& input, const Strength& strength, const LargeArray<Index>& aggregateOf)
    : Input(input)
    , Strong(strength)
    , Of(aggregateOf)
  {}
  std::vector<Index> Aggregates;
  std::vector<double> Weights; ///< sum to 1 where the matrix maps the near-null vector to 0

  void Compute(Index row)
  {
    this->Aggregates.clear();
    this->Weights.clear();
    if (this->Of.data()[row] < 0)
    {
      return;
    }
    const SparseRows& matrix = this->Input.Matrix;
    const double* smooth = this->Input.Smooth.data();
    double strong = 0.0;
    double excess = 0.0; // of the diagonal over the others
    this->Add(this->Of.data()[row], 0.0);
    for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
    {
      const Index column = matrix.Column.data()[k];
      const double value = this->Strong.Entry(row, k);
      const double weight = value * smooth[column] / smooth[row];
      excess += weight;
      if (this->Strong.IsStrong(row, k, value))
      {
        strong -= weight;
        if (this->Of.data()[column] >= 0)
        {
          this->Add(this->Of.data()[column], -weight);
        }
      }
    }
    const double diagonal = strong + std::max(excess, 0.0);
    const double factor = diagonal > 0.0 ? JacobiDamping / diagonal : 0.0;
    for (double& weight : this->Weights)
    {
      weight *= factor;
    }
    this->Weights.front() += diagonal > 0.0 ? 1.0 - JacobiDamping : 1.0;
  }

private:
  void Add(Index aggregate, double weight)
  {
    const auto found = std::find(this->Aggregates.begin(), this->Aggregates.end(), aggregate);
    if (found != this->Aggregates.end())
    {
      this->Weights[static_cast<std::size_t>(found - this->Aggregates.begin())] += weight;
      return;
    }
    this->Aggregates.push_back(aggregate);
    this->Weights.push_back(weight);
  }

  const AggregationInput& Input;
  const Strength& Strong;
  const LargeArray<Index>& Of;
};

/// Norm of the near-null vector on each aggregate.
LargeArray<double> AggregateNorms(const LargeArray<Index>& aggregateOf, Index count, const LargeArray<double>& smooth)
{
  LargeArray<double> norms(static_cast<std::size_t>(count));
  std::fill(norms.data(), norms.data() + count, 0.0);
  for (std::size_t row = 0; row < aggregateOf.size(); ++row)
  {
    if (aggregateOf[row] >= 0)
    {
      norms[static_cast<std::size_t>(aggregateOf[row])] += smooth[row] * smooth[row];
    }
  }
  for (Index aggregate = 0; aggregate < count; ++aggregate)
  {
    norms.data()[aggregate] = std::sqrt(norms.data()[aggregate]);
  }
  return norms;
}
} // namespace

AggregationResult Aggregate(const AggregationInput& input, const Progress& progress)
{
  const SparseRows& matrix = input.Matrix;
  const Strength strength(input);
  Report(progress, 0.1);
  Index count = 0;
  const LargeArray<Index> aggregateOf = Aggregator(matrix, strength).Run(count, SubProgress(progress, 0.1, 0.6));
  AggregationResult result;
  result.Smooth = AggregateNorms(aggregateOf, count, input.Smooth);

  SparseRows& prolongation = result.Prolongation;
  prolongation.Rows = matrix.Rows;
  prolongation.Columns = count;
  prolongation.Start = LargeArray<Index>(static_cast<std::size_t>(matrix.Rows) + 1);
  Index* start = prolongation.Start.data();
  const auto eachRow = [&](const auto& body) {
    ParallelFor(matrix.Rows, FineGrain, [&](std::int64_t begin, std::int64_t end) {
      InterpolationRow interpolation(input, strength, aggregateOf);
      for (auto row = static_cast<Index>(begin); row < static_cast<Index>(end); ++row)
      {
        interpolation.Compute(row);
        body(row, interpolation);
      }
    });
  };
  eachRow([&](Index row, const InterpolationRow& interpolation) {
    start[row + 1] = static_cast<Index>(interpolation.Aggregates.size());
  });
  Report(progress, 0.75);
  start[0] = 0;
  for (Index row = 0; row < matrix.Rows; ++row)
  {
    start[row + 1] += start[row];
  }
  prolongation.Column = LargeArray<Index>(static_cast<std::size_t>(prolongation.Entries()));
  prolongation.Single = LargeArray<float>(static_cast<std::size_t>(prolongation.Entries()));
  eachRow([&](Index row, const InterpolationRow& interpolation) {
    for (std::size_t k = 0; k < interpolation.Aggregates.size(); ++k)
    {
      const Index aggregate = interpolation.Aggregates[k];
      prolongation.Column.data()[static_cast<std::size_t>(start[row]) + k] = aggregate;
      prolongation.Single.data()[static_cast<std::size_t>(start[row]) + k] = static_cast<float>(
        interpolation.Weights[k] * input.Smooth.data()[row] / result.Smooth.data()[aggregate]);
    }
  });
  Report(progress, 1.0);
  return result;
}

} // namespace surfsynth
