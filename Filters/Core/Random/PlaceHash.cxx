// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Random/PlaceHash.h"

namespace surfsynth
{

std::uint64_t HashOfPlace(const std::array<std::uint64_t, 3>& numbers)
{
  std::uint64_t hash = 0;
  for (const std::uint64_t number : numbers)
  {
    hash += number + 0x9e3779b97f4a7c15;
    hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9;
    hash = (hash ^ hash >> 27) * 0x94d049bb133111eb;
    hash ^= hash >> 31;
  }
  return hash;
}

} // namespace surfsynth
