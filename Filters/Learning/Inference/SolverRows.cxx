// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Inference/SolverRows.h"

#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace surfsynth
{

SolverRows::SolverRows(std::shared_ptr<const CholeskySolver> solver, std::int64_t channels)
  : Solver(std::move(solver))
  , RowOfVertex(static_cast<std::size_t>(this->Solver->Size()))
  , NumberOfChannels(channels)
{
  for (Index row = 0; row < this->Solver->Size(); ++row)
  {
    this->RowOfVertex[this->Solver->Order()[row]] = row;
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

void SolverRows::Solve(const Progress& progress)
{
  ParallelTasks(
    static_cast<std::int64_t>(this->Blocks.size()),
    [&](std::int64_t k)
    {
      Block& block = this->Blocks[k];
      Eigen::Map<RowMatrix> rows(block.Values.data(), this->Solver->Size(), block.Columns);
      this->Solver->SolveOrderedInPlace(rows);
    },
    [&] { Report(progress, 0.0); });
}

std::vector<double> SolverRows::WeightsInOrder(const Eigen::VectorXf* mass) const
{
  std::vector<double> weights(this->RowOfVertex.size(), 1.0);
  for (std::size_t v = 0; mass && v < weights.size(); ++v)
  {
    weights[this->RowOfVertex[v]] = static_cast<double>((*mass)[static_cast<Eigen::Index>(v)]);
  }
  return weights;
}

std::vector<double> SolverRows::Moments(
  const std::vector<double>& weights, const std::vector<double>& centres, int power) const
{
  std::vector<double> sums(static_cast<std::size_t>(this->NumberOfChannels), 0.0);
  ParallelTasks(static_cast<std::int64_t>(this->Blocks.size()),
    [&](std::int64_t k)
    {
      const Block& block = this->Blocks[k];
      const double* row = block.Values.data();
      double* sum = sums.data() + block.First;
      const double* centre = centres.data() + block.First;
      for (const double weight : weights)
      {
        for (std::int64_t c = 0; c < block.Channels; ++c)
        {
          const double difference = row[c] - centre[c];
          sum[c] += weight * (power == 1 ? difference : difference * difference);
        }
        row += block.Columns;
      }
    });
  return sums;
}

SolverRows::Channels SolverRows::WithoutMean(const Eigen::VectorXf& mass) const
{
  const std::vector<double> weights = this->WeightsInOrder(&mass);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  Channels channels;
  channels.Scale.assign(static_cast<std::size_t>(this->NumberOfChannels), 1.0);
  channels.Shift = this->Moments(weights, std::vector<double>(channels.Scale.size(), 0.0), 1);
  for (double& shift : channels.Shift)
  {
    shift /= -total;
  }
  return channels;
}

SolverRows::Channels SolverRows::Normalised(
  const Eigen::VectorXf* mass, const std::vector<float>& weight, const std::vector<float>& bias) const
{
  constexpr double epsilon = 1e-12;
  const std::vector<double> weights = this->WeightsInOrder(mass);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0) + (mass ? epsilon : 0.0);
  const std::vector<double> zeros(static_cast<std::size_t>(this->NumberOfChannels), 0.0);
  std::vector<double> mean = this->Moments(weights, zeros, 1);
  std::for_each(mean.begin(), mean.end(), [total](double& value) { value /= total; });
  const std::vector<double> squares = this->Moments(weights, mean, 2);
  Channels channels{ zeros, zeros };
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
