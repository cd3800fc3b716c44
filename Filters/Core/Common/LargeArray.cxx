// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/LargeArray.h"

#include <cstdlib>
#include <limits>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace surfsynth
{

namespace
{
constexpr std::size_t CacheLine = 64;
constexpr std::size_t HugePage = std::size_t(1) << 21;
}

LargeArray::LargeArray(std::size_t size)
  : Size(size)
{
  if (size > (std::numeric_limits<std::size_t>::max() - HugePage) / sizeof(double))
  {
    throw std::bad_alloc();
  }
  const std::size_t bytes = size * sizeof(double);
  const std::size_t alignment = bytes >= 2 * HugePage ? HugePage : CacheLine;
  const std::size_t rounded = (bytes / alignment + 1) * alignment;
  this->Memory.reset(static_cast<double*>(std::aligned_alloc(alignment, rounded)));
  if (!this->Memory)
  {
    throw std::bad_alloc();
  }
#ifdef __linux__
  if (alignment == HugePage)
  {
    madvise(this->Memory.get(), rounded, MADV_HUGEPAGE); // only advice: without huge pages all works the same
  }
#endif
}

void LargeArray::Free::operator()(double* memory) const
{
  std::free(memory);
}

} // namespace surfsynth
