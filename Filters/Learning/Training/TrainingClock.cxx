// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingClock.h"

#include "Core/Common/FormatNumber.h"

#include <cstdio>

namespace surfsynth
{

namespace
{
/// Part of the weight of an iteration that is left after the next one.
constexpr double KeptWeight = 0.98;
} // namespace

std::string FormatDuration(double seconds)
{
  const auto whole = static_cast<long long>(seconds + 0.5);
  char text[48];
  std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  return text;
}

void TrainingClock::Add(const LossHistory& history)
{
  const auto iteration = static_cast<std::int64_t>(history.Size());
  const double loss = history.Last();
  this->Now = Clock::now();
  if (this->First == 0)
  {
    this->First = iteration;
    this->Begin = this->Now;
    this->Loss = loss;
  }
  this->Last = iteration;
  this->Loss = KeptWeight * this->Loss + (1.0 - KeptWeight) * loss;
}

double TrainingClock::SecondsPerIteration() const
{
  const std::int64_t timed = this->Last - this->First;
  return timed == 0 ? 0.0 : std::chrono::duration<double>(this->Now - this->Begin).count() / static_cast<double>(timed);
}

double TrainingClock::SecondsLeft() const
{
  return this->SecondsPerIteration() * static_cast<double>(this->Iterations - this->Last);
}

std::string TrainingClock::Describe() const
{
  std::string text = "iteration " + std::to_string(this->Last) + " of " + std::to_string(this->Iterations) + ", loss " +
    FormatNumber(this->Loss);
  if (this->Last > this->First)
  {
    text += ", " + FormatDuration(this->SecondsLeft()) + " left";
  }
  return text;
}

} // namespace surfsynth
