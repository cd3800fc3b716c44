// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Counter-based random numbers: every one is a pure function of its coordinates, never of an order of calls.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// The coordinates of a stream of normals. Philox 4x32-10 (Salmon et al. 2011, Random123) is keyed by the seed and
/// counts (point / 4, component, sample, stream), so the k-th number of two streams that differ in any field is
/// independent.
struct NormalKey
{
  std::uint64_t Seed = 0;
  std::uint32_t Sample = 0;
  std::uint32_t Component = 0;
  /// Distinguishes uses that share a seed; filters put the block's flat index of a composite input here.
  std::uint32_t Stream = 0;
};

/// Writes N(0, 1) numbers for the points [@p first, @p first + @p count) to @p out.
///
/// Box-Muller on 32-bit uniforms, in float64 arithmetic that uses no libm function whose last bit differs between
/// systems; the tail ends at 6.7 standard deviations. @p first must be a multiple of 4; points are below 2^34.
void FillNormals(const NormalKey& key, std::int64_t first, std::int64_t count, double* out);

/// The single N(0, 1) number of one point.
double Normal(const NormalKey& key, std::int64_t point);

} // namespace surfsynth
