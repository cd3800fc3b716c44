// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Counter-based uniform random numbers, for choices: of samples, times, initial weights [Salmon2011].
#pragma once

#include "Core/Random/CounterNormals.h"

#include <cstdint>

namespace surfsynth
{

/// Returns the uniform number of @p key at @p point in [0, 1), a multiple of 2^-32. Philox 4x32-10 as in FillNormals(),
/// with another key, so that both may share a seed. @p point is below 2^34.
double Uniform(const NormalKey& key, std::int64_t point);

/// Returns a whole number in [0, @p count), each equally likely to within 2^-32; @p count >= 1.
std::int64_t UniformIndex(const NormalKey& key, std::int64_t point, std::int64_t count);

} // namespace surfsynth
