// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Comparison of named numbers with a file of Testing/Data.
#pragma once

#include <map>
#include <string>

namespace surfsynthtest
{

using Numbers = std::map<std::string, double>;

/// File of named numbers: lines of a name and a number.
struct NumberBaseline
{
  std::string File;
  std::size_t Size = 0;   ///< count of numbers in it
  double Tolerance = 0.0; ///< of the difference, relative to numbers above 1
  int Digits = 17;        ///< significant digits when it is written
};

/// Expects that @p found are the numbers of the file. With SURFACE_SYNTHESIS_REGENERATE_BASELINES in the environment
/// writes the file instead, and skips the test. To be called at the end of a test.
void ExpectBaseline(const Numbers& found, const NumberBaseline& baseline);

} // namespace surfsynthtest
