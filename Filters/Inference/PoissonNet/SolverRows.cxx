// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/SolverRows.h"

#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

namespace surfsynth
{

SolverRows::SolverRows(std::shared_ptr<const CholeskySolver> solver, std::int64_t channels, const Eigen::VectorXf& mass,
  const std::vector<Index>& unused)
  : Solver(std::move(solver))
  , RowOfVertex(static_cast<std::size_t>(this->Solver->Size()))
  , Unused(unused)
  , NumberOfChannels(channels)
{
  for (Index row = 0; row < this->Solver->Size(); ++row)
  {
    this->RowOfVertex[this->Solver->Order()[row]] = row;
    this->MassInOrder.push_back(static_cast<double>(mass[this->Solver->Order()[row]]));
  }
  constexpr std::int64_t granularity = CholeskySolver::ColumnGranularity;
  for (std::int64_t first = 0; first < channels; first += CholeskySolver::BlockColumns)
  {
    const std::int64_t count = std::min<std::int64_t>(CholeskySolver::BlockColumns, channels - first);
    const std::int64_t columns = (count + granularity - 1) / granularity * granularity;
    LargeArray<double> values(static_cast<std::size_t>(this->Solver->Size() * columns));
    std::fill_n(values.data(), values.size(), 0.0);
    this->Blocks.push_back({ first, count, columns, std::move(values) });
  }
}

void SolverRows::Set(Index vertex, const float* values)
{
  for (Block& block : this->Blocks)
  {
    double* row = block.Values.data() + this->RowOfVertex[vertex] * block.Columns;
    std::copy_n(values + block.First, block.Channels, row);
  }
}

void SolverRows::Add(const RowMatrix& values)
{
  for (Block& block : this->Blocks)
  {
    for (Eigen::Index vertex = 0; vertex < values.rows(); ++vertex)
    {
      double* row = block.Values.data() + this->RowOfVertex[vertex] * block.Columns;
      for (std::int64_t c = 0; c < block.Channels; ++c)
      {
        row[c] += values(vertex, block.First + c);
      }
    }
  }
}

template <typename Values>
void SolverRows::SetUnused(const Values& values)
{
  for (const Index vertex : this->Unused)
  {
    for (Block& block : this->Blocks)
    {
      double* row = block.Values.data() + this->RowOfVertex[vertex] * block.Columns;
      std::copy_n(values.begin() + block.First, block.Channels, row);
    }
  }
}

void SolverRows::Solve(const Progress& progress)
{
  const std::vector<double> zeros(static_cast<std::size_t>(this->NumberOfChannels), 0.0);
  this->SetUnused(zeros);
  ParallelTasks(
    static_cast<std::int64_t>(this->Blocks.size()),
    [&](std::int64_t k) {
      Block& block = this->Blocks[k];
      Eigen::Map<RowMatrix> rows(block.Values.data(), this->Solver->Size(), block.Columns);
      this->Solver->SolveOrderedInPlace(rows);
    },
    [&] { Report(progress, 0.0); });
  const double total = std::accumulate(this->MassInOrder.begin(), this->MassInOrder.end(), 0.0);
  this->Means = this->Moments(this->MassInOrder, zeros, 1);
  std::for_each(this->Means.begin(), this->Means.end(), [total](double& mean) { mean /= total; });
  this->SetUnused(this->Means);
}

std::vector<double> SolverRows::Moments(
  const std::vector<double>& weights, const std::vector<double>& centers, int power) const
{
  std::vector<double> sums(static_cast<std::size_t>(this->NumberOfChannels), 0.0);
  ParallelTasks(static_cast<std::int64_t>(this->Blocks.size()), [&](std::int64_t k) {
    const Block& block = this->Blocks[k];
    const double* row = block.Values.data();
    double* sum = sums.data() + block.First;
    const double* center = centers.data() + block.First;
    for (const double weight : weights)
    {
      for (std::int64_t c = 0; c < block.Channels; ++c)
      {
        const double difference = row[c] - center[c];
        sum[c] += weight * (power == 1 ? difference : difference * difference);
      }
      row += block.Columns;
    }
  });
  return sums;
}

SolverRows::Channels SolverRows::WithoutMean() const
{
  Channels channels;
  channels.Scale.assign(this->Means.size(), 1.0);
  std::transform(this->Means.begin(), this->Means.end(), std::back_inserter(channels.Shift), std::negate<double>());
  return channels;
}

SolverRows::Channels SolverRows::Normalized(
  bool massWeighted, const std::vector<float>& weight, const std::vector<float>& bias) const
{
  constexpr double epsilon = 1e-12;
  const std::vector<double> weights = massWeighted ? this->MassInOrder
                                                   : std::vector<double>(this->MassInOrder.size(), 1.0);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0) + (massWeighted ? epsilon : 0.0);
  // Taken from the values without their weighted mean, which may be far larger than their differences.
  std::vector<double> mean = this->Moments(weights, this->Means, 1);
  for (std::size_t c = 0; c < mean.size(); ++c)
  {
    mean[c] = this->Means[c] + mean[c] / total;
  }
  const std::vector<double> squares = this->Moments(weights, mean, 2);
  Channels channels{ mean, mean };
  for (std::size_t c = 0; c < mean.size(); ++c)
  {
    channels.Scale[c] = static_cast<double>(weight[c]) / std::sqrt(squares[c] / total + epsilon);
    channels.Shift[c] = static_cast<double>(bias[c]) - mean[c] * channels.Scale[c];
  }
  return channels;
}

void SolverRows::Get(Index vertex, const Channels& channels, float* values) const
{
  for (const Block& block : this->Blocks)
  {
    const double* row = block.Values.data() + this->RowOfVertex[vertex] * block.Columns;
    for (std::int64_t c = 0; c < block.Channels; ++c)
    {
      const std::int64_t channel = block.First + c;
      values[channel] = static_cast<float>(row[c] * channels.Scale[channel] + channels.Shift[channel]);
    }
  }
}

} // namespace surfsynth
