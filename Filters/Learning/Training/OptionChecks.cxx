// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/OptionChecks.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <cmath>
#include <utility>

namespace surfsynth
{

OptionChecks::OptionChecks(std::string options)
  : Options(std::move(options))
{}

void OptionChecks::Require(
  bool fine, const std::string& option, const std::string& found, const std::string& expected) const
{
  if (!fine)
  {
    throw InvalidInput(this->Options + ": " + option + " is " + found + "; expected " + expected + ".");
  }
}

void OptionChecks::Require(bool fine, const std::string& option, double found, const std::string& expected) const
{
  this->Require(fine, option, FormatNumber(found), expected);
}

void OptionChecks::Count(
  const std::string& option, std::int64_t found, std::int64_t smallest, std::int64_t largest) const
{
  this->Require(found >= smallest && found <= largest, option, std::to_string(found),
    std::to_string(smallest) + " to " + std::to_string(largest));
}

void OptionChecks::Iterations(const std::string& option, std::int64_t found) const
{
  this->Require(found >= 1 && found <= 100000000, option, std::to_string(found), "1 to 1e8");
}

void OptionChecks::Weight(const std::string& option, double found) const
{
  this->Require(std::isfinite(found) && found >= 0.0, option, found, "a finite number of at least 0");
}

void OptionChecks::Positive(const std::string& option, double found) const
{
  this->Require(std::isfinite(found) && found > 0.0, option, found, "a finite number above 0");
}

void OptionChecks::LearningRate(const std::string& option, double found) const
{
  this->Require(found > 0.0 && found <= 1e30, option, found, "a number above 0 and at most 1e30");
}

void OptionChecks::Factor(const std::string& option, double found) const
{
  this->Require(found > 0.0 && found <= 1.0, option, found, "a number in (0, 1]");
}

} // namespace surfsynth
