// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Normals in bulk. Private to the random numbers.
#pragma once

#include "Core/Random/CounterNormals.h"

namespace surfsynth
{

/// Number of counters of one call; each gives the normals of four points.
constexpr int NormalBlocksAtOnce = 64;

/// Writes the 4 NormalBlocksAtOnce normals of points 4 firstBlock, 4 firstBlock + 1, ... to @p out. The variants are
/// the same source compiled for different instruction sets and give the same bits.
void FillNormalBlocksGeneric(const NormalKey& key, std::uint32_t firstBlock, double* out);
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
/// The variant for AVX2.
void FillNormalBlocksAvx2(const NormalKey& key, std::uint32_t firstBlock, double* out);
/// The variant for AVX-512.
void FillNormalBlocksAvx512(const NormalKey& key, std::uint32_t firstBlock, double* out);
#endif

} // namespace surfsynth
