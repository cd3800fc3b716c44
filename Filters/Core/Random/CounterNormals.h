// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Counter-based normal random numbers: each is a pure function of its coordinates, never of an order of calls.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// The coordinates of a stream of normals. Philox 4x32-10 of Random123 [Salmon2011] is keyed by the seed and counts
/// (point / 4, component, sample, stream), so the k-th number of two streams that differ in any field is independent.
struct NormalKey
{
  std::uint64_t Seed = 0;      ///< seed of the caller
  std::uint32_t Sample = 0;    ///< number of the sample
  std::uint32_t Component = 0; ///< number of the component
  /// Number of the stream: distinguishes uses that share a seed. For a composite input, the flat index of the block.
  std::uint32_t Stream = 0;
};

/// Writes N(0, 1) numbers for the points [@p first, @p first + @p count) to @p out.
///
/// The method of Box and Muller [Box1958] on 32-bit uniforms, in float64 arithmetic without libm functions, whose last
/// bits differ between systems; the tail ends at 6.7 standard deviations. @p first must be a multiple of 4; points are
/// below 2^34.
void FillNormals(const NormalKey& key, std::int64_t first, std::int64_t count, double* out);

/// Returns the N(0, 1) number of one point: the same as that of FillNormals().
double Normal(const NormalKey& key, std::int64_t point);

} // namespace surfsynth
