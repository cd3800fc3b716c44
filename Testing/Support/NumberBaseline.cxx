// SPDX-License-Identifier: BSD-3-Clause
#include "NumberBaseline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace surfsynthtest
{

namespace
{
Numbers ReadNumbers(const std::string& path)
{
  Numbers numbers;
  std::ifstream file(path);
  std::string name;
  for (double value; file >> name >> value;)
  {
    numbers[name] = value;
  }
  return numbers;
}

void WriteNumbers(const Numbers& numbers, const NumberBaseline& baseline)
{
  std::ofstream file(baseline.File);
  file.precision(baseline.Digits);
  for (const auto& number : numbers)
  {
    file << number.first << " " << number.second << "\n";
  }
}
} // namespace

void ExpectBaseline(const Numbers& found, const NumberBaseline& baseline)
{
  if (std::getenv("SURFACE_SYNTHESIS_REGENERATE_BASELINES"))
  {
    WriteNumbers(found, baseline);
    GTEST_SKIP() << "wrote " << baseline.File;
  }
  const Numbers expected = ReadNumbers(baseline.File);
  ASSERT_EQ(expected.size(), baseline.Size) << baseline.File;
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& number : expected)
  {
    ASSERT_EQ(found.count(number.first), 1u) << number.first;
    EXPECT_NEAR(found.at(number.first), number.second, baseline.Tolerance * std::max(1.0, std::abs(number.second)))
      << number.first;
  }
}

} // namespace surfsynthtest
