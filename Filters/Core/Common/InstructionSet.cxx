// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/InstructionSet.h"

#include "Core/Common/Errors.h"

#include <atomic>
#include <cstdlib>
#include <iterator>
#include <string>

namespace surfsynth
{

namespace
{
constexpr const char* Variable = "SURFACE_SYNTHESIS_INSTRUCTION_SET";
constexpr const char* Names[] = { "generic", "avx2", "avx512" };
constexpr int NotSet = -1;

std::atomic<int> Chosen{ NotSet };

void RequireInstructionSet(InstructionSet set, const std::string& function)
{
  if (!HasInstructionSet(set))
  {
    throw InvalidInput(function + ": this processor, or this build, lacks the instruction set " +
      Names[static_cast<int>(set)] + "; expected one that it has, such as generic.");
  }
}

InstructionSet DefaultInstructionSet()
{
  if (const char* text = std::getenv(Variable); text && *text != '\0')
  {
    for (int k = 0; k < static_cast<int>(std::size(Names)); ++k)
    {
      if (std::string(text) == Names[k])
      {
        RequireInstructionSet(static_cast<InstructionSet>(k), Variable);
        return static_cast<InstructionSet>(k);
      }
    }
    throw InvalidInput(std::string(Variable) + " is \"" + text + "\"; expected generic, avx2 or avx512.");
  }
  return HasInstructionSet(InstructionSet::Avx512) ? InstructionSet::Avx512
    : HasInstructionSet(InstructionSet::Avx2)      ? InstructionSet::Avx2
                                                   : InstructionSet::Generic;
}
} // namespace

bool HasInstructionSet(InstructionSet set)
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  if (set == InstructionSet::Avx512)
  {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && HasInstructionSet(InstructionSet::Avx2);
  }
  if (set == InstructionSet::Avx2)
  {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  }
#endif
  return set == InstructionSet::Generic;
}

InstructionSet CurrentInstructionSet()
{
  if (const int chosen = Chosen; chosen != NotSet)
  {
    return static_cast<InstructionSet>(chosen);
  }
  static const InstructionSet standard = DefaultInstructionSet();
  return standard;
}

void SetInstructionSet(InstructionSet set)
{
  RequireInstructionSet(set, "SetInstructionSet");
  Chosen = static_cast<int>(set);
}

} // namespace surfsynth
