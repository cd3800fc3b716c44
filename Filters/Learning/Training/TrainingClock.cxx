// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingClock.h"

#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cstdio>

namespace surfsynth
{

namespace
{
/// Part of the weight of an iteration that is left after the next one.
constexpr double KeptWeight = 0.98;
/// Seconds that a forecast needs, and the shortest time that is worth one.
constexpr double MeasuredSeconds = 1.0;
constexpr double ForecastSeconds = 60.0;
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
  const double loss = history.Last();
  const bool first = this->First == 0;
  this->Add(static_cast<std::int64_t>(history.Size()));
  this->Loss = first ? loss : KeptWeight * this->Loss + (1.0 - KeptWeight) * loss;
}

void TrainingClock::Add(std::int64_t iteration)
{
  this->Now = Clock::now();
  if (this->First == 0)
  {
    this->First = iteration;
    this->Begin = this->Now;
  }
  this->Last = iteration;
}

double TrainingClock::CostUntil(std::int64_t iteration) const
{
  double cost = 0.0;
  double begin = 0.0;
  for (std::size_t stage = 0; stage < this->Costs.size(); ++stage)
  {
    cost += this->Costs[stage] * std::clamp(static_cast<double>(iteration) - begin, 0.0, this->Lengths[stage]);
    begin += this->Lengths[stage];
  }
  return cost;
}

double TrainingClock::SecondsLeft() const
{
  const double done = this->CostUntil(this->Last) - this->CostUntil(this->First);
  const double left = this->CostUntil(this->Iterations) - this->CostUntil(this->Last);
  return done > 0.0 ? this->SecondsMeasured() * left / done : 0.0;
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

std::string TrainingClock::TakeForecast()
{
  if (this->Forecast || this->Last == this->First || this->SecondsMeasured() < MeasuredSeconds)
  {
    return "";
  }
  this->Forecast = true;
  const double seconds = this->SecondsLeft();
  return seconds < ForecastSeconds ? ""
                                   : "The other " + std::to_string(this->Iterations - this->Last) + " of " +
      std::to_string(this->Iterations) + " iterations take about " + FormatDuration(seconds) + ".";
}

} // namespace surfsynth
