// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Memory of the operators and factorisations of the surfaces of a training. This header needs no torch.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Use of the memory that FlowMatchingTrainingOptions::SourceMemory limits.
struct SourceMemoryUse
{
  std::uint64_t Bytes = 0;   ///< of what is kept now
  std::uint64_t Peak = 0;    ///< largest number of bytes that were kept at once
  std::int64_t Builds = 0;   ///< number of sources built because they were not kept, since the trainer was begun
  double BuildSeconds = 0.0; ///< time of these
};

} // namespace surfsynth
