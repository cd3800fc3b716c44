// SPDX-License-Identifier: BSD-3-Clause
#include "SampleMemory.h"

#include "DistributedSurfaces.h"

#include "Core/Common/FormatNumber.h"

#include <vtkDataObject.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr double GiB = 1024.0 * 1024.0 * 1024.0;

/// Number in a file of one number; the largest one when there is none, as in "max".
std::int64_t NumberIn(const char* path)
{
  std::ifstream file(path);
  std::int64_t number = 0;
  return file >> number && number > 0 ? number : std::numeric_limits<std::int64_t>::max();
}

double ElementsOf(vtkDataObject* data, int type)
{
  return data ? static_cast<double>(std::max<vtkIdType>(data->GetNumberOfElements(type), 0)) : 0.0;
}
} // namespace

std::int64_t DefaultMemoryLimit()
{
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long size = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0)
  {
    return 0;
  }
  std::int64_t bytes = static_cast<std::int64_t>(pages) * size;
  bytes = std::min(bytes, NumberIn("/sys/fs/cgroup/memory.max"));
  bytes = std::min(bytes, NumberIn("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
  rlimit space{};
  if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
  {
    bytes = std::min(bytes, static_cast<std::int64_t>(space.rlim_cur));
  }
  return bytes / 4 * 3;
}

std::string ProblemOfMemory(vtkDataObject* input, const SampleMemory& memory)
{
  const double limit = static_cast<double>(memory.MemoryLimit > 0 ? memory.MemoryLimit << 20 : DefaultMemoryLimit());
  const double points = ElementsOf(input, vtkDataObject::POINT);
  const double sample = memory.BytesOfSample + memory.BytesOfPoint * points +
    memory.BytesOfCell * ElementsOf(input, vtkDataObject::CELL);
  const double needed = sample * memory.NumberOfSamples;
  std::string problem;
  if (limit > 0.0 && needed > limit)
  {
    const double fitting = std::floor(limit / sample);
    problem = "About " + FormatNumber(needed / GiB) + " GiB would be needed for " +
      std::to_string(memory.NumberOfSamples) + " sample(s) on " + FormatNumber(points) + " points; at most " +
      FormatNumber(limit / GiB) + " GiB are allowed (MemoryLimit). " +
      (fitting >= 1.0 ? "A NumberOfSamples of " + std::to_string(static_cast<std::int64_t>(fitting)) + " fits."
                      : "No sample fits; a surface with fewer points, or a larger limit, is needed.");
  }
  return Ranks(Ranks::Several()).FirstText(problem);
}

} // namespace surfsynth
