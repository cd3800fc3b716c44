// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Hash of places in space, which number the random numbers there.
#pragma once

#include <array>
#include <cstdint>

namespace surfsynth
{

/// Mixes three numbers, such as the coordinates of a lattice cell, into 64 bits, by the finalizer of SplitMix64.
std::uint64_t HashOfPlace(const std::array<std::uint64_t, 3>& numbers);

} // namespace surfsynth
