// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Grains of ParallelFor() in loops over elements of a mesh: least items of a range that pay for a thread.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// For items of some ten nanoseconds: comparisons, copies, sums.
constexpr std::int64_t FineGrain = 16384;
/// For items of some hundred nanoseconds: normals, small searches.
constexpr std::int64_t CoarseGrain = 8192;

} // namespace surfsynth
