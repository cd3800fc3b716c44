// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Memory that this process may still take. Private to the plain libraries.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Estimates the bytes that this process can still allocate: the least of the machine's available memory (Linux'
/// MemAvailable), of what the control group of the process leaves, and of what its limit of address space
/// (RLIMIT_AS) leaves. 2^63 - 1 where nothing is known. Other processes may take some of it at any time.
std::uint64_t AvailableMemory();

} // namespace surfsynth
