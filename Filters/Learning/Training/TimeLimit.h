// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The time budget of a run. No torch.
#pragma once

#include <algorithm>
#include <chrono>

namespace surfsynth
{

/// Measures time from its construction on against a budget.
class TimeLimit
{
public:
  /// @param minutes the budget; 0: no limit.
  explicit TimeLimit(double minutes)
    : Seconds(60.0 * minutes)
  {}

  /// True when there is a budget.
  bool Exists() const { return this->Seconds > 0.0; }
  /// Seconds since the construction.
  double Elapsed() const { return std::chrono::duration<double>(Clock::now() - this->Begin).count(); }
  /// Minutes of the budget that are left, larger than 0 also when it is used up; 0, no limit, without a budget.
  double MinutesLeft() const { return this->Exists() ? std::max(1e-6, this->Seconds - this->Elapsed()) / 60.0 : 0.0; }
  /// True when the budget is used up.
  bool IsReached() const { return this->Exists() && this->Elapsed() >= this->Seconds; }

private:
  using Clock = std::chrono::steady_clock;

  double Seconds;
  Clock::time_point Begin = Clock::now();
};

} // namespace surfsynth
