// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Loss and remaining time of a training that runs. No torch.
#pragma once

#include "Learning/Training/LossHistory.h"

#include <chrono>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

/// "1:02:03" for 3723 seconds.
std::string FormatDuration(double seconds);

/// Smooths the monitored loss of a training and estimates its remaining time.
class TrainingClock
{
public:
  /// @param iterations of the whole training, those of a checkpoint included.
  /// @param costs time of an iteration of each stage in any unit, where a training has stages of equally many iterations.
  explicit TrainingClock(std::int64_t iterations, std::vector<double> costs = { 1.0 })
    : Iterations(iterations)
    , Costs(std::move(costs))
    , Lengths(this->Costs.size(), static_cast<double>(iterations) / static_cast<double>(this->Costs.size()))
  {}
  /// A training whose stages have these numbers of iterations, one cost for each.
  TrainingClock(const std::vector<std::int64_t>& iterations, std::vector<double> costs)
    : Iterations(std::accumulate(iterations.begin(), iterations.end(), std::int64_t(0)))
    , Costs(std::move(costs))
    , Lengths(iterations.begin(), iterations.end())
  {}

  /// Number of iterations of the whole training.
  std::int64_t NumberOfIterations() const { return this->Iterations; }

  /// Takes note of the last iteration of @p history, which has one; the first call begins the measurement of time.
  void Add(const LossHistory& history);
  /// The same for a number of iterations done, from 1 on, without a loss.
  void Add(std::int64_t iteration);

  /// Mean loss, in which the weight of an iteration falls by 2 % with each one after it; 0 before the first.
  double SmoothedLoss() const { return this->Loss; }
  /// Estimated seconds to the last iteration; 0 before the second.
  double SecondsLeft() const;
  /// "iteration 120 of 2000, loss 0.0123, 0:01:23 left"
  std::string Describe() const;
  /// "The other 19997 of 20000 iterations take about 21:03:00." once, as soon as an iteration and a second have been
  /// measured, when that is a minute or more; else empty.
  std::string TakeForecast();

private:
  using Clock = std::chrono::steady_clock;

  double CostUntil(std::int64_t iteration) const;
  double SecondsMeasured() const { return std::chrono::duration<double>(this->Now - this->Begin).count(); }

  std::int64_t Iterations;
  std::vector<double> Costs;
  std::vector<double> Lengths; ///< iterations of each stage
  bool Forecast = false;
  std::int64_t First = 0;
  std::int64_t Last = 0;
  double Loss = 0.0;
  Clock::time_point Begin;
  Clock::time_point Now;
};

} // namespace surfsynth
