// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Checks of the options of trainings. Private to the training; no torch.
#pragma once

#include <cstdint>
#include <string>

namespace surfsynth
{

/// Checks options one by one; each check throws InvalidInput "<options>: <option> is <found>; expected <expected>."
class OptionChecks
{
public:
  /// @param options name of the options, for messages.
  explicit OptionChecks(std::string options);

  void Require(bool fine, const std::string& option, const std::string& found, const std::string& expected) const;
  void Require(bool fine, const std::string& option, double found, const std::string& expected) const;
  /// A whole number from @p smallest to @p largest.
  void Count(const std::string& option, std::int64_t found, std::int64_t smallest, std::int64_t largest) const;
  /// A number of iterations, from 1 to 1e8.
  void Iterations(const std::string& option, std::int64_t found) const;
  /// A finite number of at least 0.
  void Weight(const std::string& option, double found) const;
  /// A finite number above 0.
  void Positive(const std::string& option, double found) const;
  /// A number above 0 whose multiples are finite in single precision: at most 1e30.
  void LearningRate(const std::string& option, double found) const;
  /// A number in (0, 1].
  void Factor(const std::string& option, double found) const;

private:
  std::string Options;
};

} // namespace surfsynth
