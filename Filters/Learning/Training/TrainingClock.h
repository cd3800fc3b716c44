// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a training says of itself while it runs. No torch.
#pragma once

#include "Learning/Training/FlowMatchingTrainer.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace surfsynth
{

/// Follows a training on the clock: how its loss goes, and how long it will still take.
class TrainingClock
{
public:
  /// @param iterations of the whole training, those of a checkpoint included.
  explicit TrainingClock(std::int64_t iterations)
    : Iterations(iterations)
  {}

  /// Takes note of one iteration; the first one that it is told of begins the measuring of time.
  void Add(const TrainingStep& step);

  /// Mean loss, in which the weight of an iteration falls by 2 % with each one after it; 0 before the first.
  double SmoothedLoss() const { return this->Loss; }
  /// Seconds for an iteration; 0 before the second.
  double SecondsPerIteration() const;
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
