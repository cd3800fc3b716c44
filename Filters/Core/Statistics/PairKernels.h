// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loop of the distance of two samples, once for each instruction set. Private to the core.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Some points of two samples: component c of point p at [c * Count + p].
struct PairOfPlanes
{
  const double* A = nullptr;       ///< [Components, Count], the first sample
  const double* B = nullptr;       ///< [Components, Count], the second sample
  const double* Weights = nullptr; ///< [Count]
  std::int64_t Components = 1;     ///< number of components
  std::int64_t Count = 0;          ///< number of points
  bool Squared = false;            ///< add up squares, not lengths
};

/// Computes sum_p w_p || a_p - b_p ||, or with the squares of the norms. The same bits in all variants: eight sums, of
/// every eighth point, are added up in the end.
double AddUpPairGeneric(const PairOfPlanes& pair);
/// The variant for AVX2.
double AddUpPairAvx2(const PairOfPlanes& pair);
/// The variant for AVX-512.
double AddUpPairAvx512(const PairOfPlanes& pair);

} // namespace surfsynth
