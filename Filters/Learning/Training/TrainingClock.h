// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Loss and remaining time of a training that runs. No torch.
#pragma once

#include "Learning/Training/LossHistory.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace surfsynth
{

/// "1:02:03" for 3723 seconds.
std::string FormatDuration(double seconds);

/// Smooths the monitored loss of a training and estimates its remaining time.
class TrainingClock
{
public:
  /// @param iterations of the whole training, those of a checkpoint included.
  explicit TrainingClock(std::int64_t iterations)
    : Iterations(iterations)
  {}

  /// Takes note of the last iteration of @p history, which has one; the first call begins the measurement of time.
  void Add(const LossHistory& history);

  /// Mean loss, in which the weight of an iteration falls by 2 % with each one after it; 0 before the first.
  double SmoothedLoss() const { return this->Loss; }
  /// Seconds for an iteration; 0 before the second.
  double SecondsPerIteration() const;
  /// Estimated seconds to the last iteration; 0 before the second.
  double SecondsLeft() const;
  /// "iteration 120 of 2000, loss 0.0123, 0:01:23 left"
  std::string Describe() const;

private:
  using Clock = std::chrono::steady_clock;

  std::int64_t Iterations;
  std::int64_t First = 0;
  std::int64_t Last = 0;
  double Loss = 0.0;
  Clock::time_point Begin;
  Clock::time_point Now;
};

} // namespace surfsynth
