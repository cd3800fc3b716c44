// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the AddUpPair variants, included once for each instruction set by a file that defines
/// SURFSYNTH_ADD_UP_PAIR (name of the function to define).
///
/// The loops over lanes are plain so that compilers turn them into vector code; contraction of products and sums is
/// off, so that the bits are the same everywhere: see the flags in CMakeLists.txt. Calls no inline function with
/// external linkage: the linker might keep the copy that was compiled for the wide instruction set for everybody.
#pragma once

#include "Core/Statistics/PairKernels.h"

namespace surfsynth
{

namespace
{
constexpr int Lanes = 8;

/// Adds the points from @p first on, as many as there are lanes or @p lanes, to their sums. @p Components is 0 for any
/// number of components.
template <int Components, bool Squared>
inline void AddPoints(const PairOfPlanes& pair, std::int64_t first, int lanes, double* sums)
{
  const std::int64_t components = Components > 0 ? Components : pair.Components;
  double squares[Lanes] = {};
  for (std::int64_t c = 0; c < components; ++c)
  {
    const double* a = pair.A + c * pair.Count + first;
    const double* b = pair.B + c * pair.Count + first;
    for (int lane = 0; lane < lanes; ++lane)
    {
      const double difference = a[lane] - b[lane];
      squares[lane] += difference * difference;
    }
  }
  const double* weights = pair.Weights + first;
  for (int lane = 0; lane < lanes; ++lane)
  {
    sums[lane] += weights[lane] * (Squared ? squares[lane] : __builtin_sqrt(squares[lane]));
  }
}

template <int Components, bool Squared>
double AddUp(const PairOfPlanes& pair)
{
  double sums[Lanes] = {};
  std::int64_t first = 0;
  for (; first + Lanes <= pair.Count; first += Lanes)
  {
    AddPoints<Components, Squared>(pair, first, Lanes, sums);
  }
  AddPoints<Components, Squared>(pair, first, static_cast<int>(pair.Count - first), sums);
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

template <int Components>
double AddUpPair(const PairOfPlanes& pair)
{
  return pair.Squared ? AddUp<Components, true>(pair) : AddUp<Components, false>(pair);
}
} // namespace

double SURFSYNTH_ADD_UP_PAIR(const PairOfPlanes& pair)
{
  switch (pair.Components)
  {
    case 1:
      return AddUpPair<1>(pair);
    case 3:
      return AddUpPair<3>(pair);
    default:
      return AddUpPair<0>(pair);
  }
}

} // namespace surfsynth
