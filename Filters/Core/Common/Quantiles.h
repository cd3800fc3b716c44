// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Quantiles of numbers in ascending order.
#pragma once

#include <Eigen/Core>

#include <algorithm>

namespace surfsynth
{

/// Quantile of N numbers: the value at place p (N - 1), linear between two of them, type 7 of [Hyndman1996].
/// @param sorted [N], ascending, N at least 1
/// @param probability p, from 0 to 1
inline double QuantileOfSorted(const double* sorted, Eigen::Index count, double probability)
{
  const double place = probability * static_cast<double>(count - 1);
  const auto below = std::min(static_cast<Eigen::Index>(place), count - 1);
  const double above = sorted[std::min(below + 1, count - 1)];
  return sorted[below] + (place - static_cast<double>(below)) * (above - sorted[below]);
}

} // namespace surfsynth
