// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Counter-based uniform numbers, for choices: which sample, what time, which initial weight.
#pragma once

#include "Core/Random/CounterNormals.h"

#include <cstdint>

namespace surfsynth
{

/// The number of @p key at @p point in [0, 1), a multiple of 2^-32: Philox 4x32-10 as FillNormals() uses it, with another
/// key, so that both may share a seed. @p point is below 2^34.
double Uniform(const NormalKey& key, std::int64_t point);

/// A whole number in [0, @p count), each equally likely to within 2^-32 of its probability; @p count >= 1.
std::int64_t UniformIndex(const NormalKey& key, std::int64_t point, std::int64_t count);

} // namespace surfsynth
