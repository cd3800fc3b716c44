// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/AvailableMemory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
constexpr std::uint64_t Unknown = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());

/// The first number of a file; Unknown without one ("max" stands for no limit).
std::uint64_t NumberIn(const std::string& file)
{
  std::uint64_t number = 0;
  return std::ifstream(file) >> number ? number : Unknown;
}

/// The number behind @p wanted at the beginning of a line; Unknown without one.
std::uint64_t NumberBehind(const std::string& file, const std::string& wanted)
{
  std::ifstream stream(file);
  std::string key;
  while (stream >> key)
  {
    std::uint64_t number = 0;
    if (key == wanted && stream >> number)
    {
      return number;
    }
    stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return Unknown;
}

std::uint64_t MemoryOfMachine()
{
  const std::uint64_t kibibytes = NumberBehind("/proc/meminfo", "MemAvailable:");
  return kibibytes == Unknown ? Unknown : kibibytes * 1024;
}

std::uint64_t MemoryOfControlGroup()
{
  const std::uint64_t limit = NumberIn("/sys/fs/cgroup/memory.max");
  const std::uint64_t used = NumberIn("/sys/fs/cgroup/memory.current");
  const std::uint64_t files = NumberBehind("/sys/fs/cgroup/memory.stat", "inactive_file"); // can be taken back
  const std::uint64_t kept = files == Unknown ? used : used - std::min(files, used);
  return limit == Unknown || used == Unknown ? Unknown : limit - std::min(kept, limit);
}

std::uint64_t AddressSpace()
{
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
  {
    return Unknown;
  }
  const std::uint64_t pages = NumberIn("/proc/self/statm");
  const std::uint64_t used = pages == Unknown ? 0 : pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return static_cast<std::uint64_t>(limit.rlim_cur) - std::min<std::uint64_t>(used, limit.rlim_cur);
}
} // namespace

std::uint64_t AvailableMemory() { return std::min({ MemoryOfMachine(), MemoryOfControlGroup(), AddressSpace() }); }

} // namespace surfsynth
