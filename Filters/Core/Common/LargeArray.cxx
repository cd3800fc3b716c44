// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/LargeArray.h"

#include <cstdlib>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace surfsynth
{

namespace
{
constexpr std::size_t CacheLine = 64;
constexpr std::size_t HugePage = std::size_t(1) << 21;
} // namespace

void* AllocateLarge(std::size_t bytes)
{
  if (bytes > std::numeric_limits<std::size_t>::max() - 2 * HugePage)
  {
    throw std::bad_alloc();
  }
  const std::size_t alignment = bytes >= 2 * HugePage ? HugePage : CacheLine;
  const std::size_t rounded = (bytes / alignment + 1) * alignment;
  void* memory = std::aligned_alloc(alignment, rounded);
  if (!memory)
  {
    throw std::bad_alloc();
  }
#ifdef __linux__
  if (alignment == HugePage)
  {
    madvise(memory, rounded, MADV_HUGEPAGE); // only advice: without huge pages all works the same
  }
#endif
  return memory;
}

void FreeLarge(void* memory) { std::free(memory); }

} // namespace surfsynth
