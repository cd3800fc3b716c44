// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The inner loop of the distance of two samples, once for each instruction set. Private to the core.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Some points of two samples: component c of point p at [c * Count + p].
struct PairOfPlanes
{
  const double* A = nullptr;
  const double* B = nullptr;
  const double* Weights = nullptr; ///< [Count]
  std::int64_t Components = 1;
  std::int64_t Count = 0;
  bool Squared = false; ///< add up squares, not lengths
};

/// sum_p w_p || a_p - b_p ||, or with the squares of the norms. The same bits in all variants: eight sums, of every
/// eighth point, are added up in the end.
double AddUpPairGeneric(const PairOfPlanes& pair);
double AddUpPairAvx2(const PairOfPlanes& pair);
double AddUpPairAvx512(const PairOfPlanes& pair);

} // namespace surfsynth
