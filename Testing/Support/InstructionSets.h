// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The same computation with all instruction sets that this processor has.
#pragma once

#include "Core/Common/InstructionSet.h"

#include <functional>

namespace surfsynth::test
{

/// Calls @p body with each instruction set in use, generic first, and then puts back the one that was.
inline void ForEachInstructionSet(const std::function<void(InstructionSet)>& body)
{
  const InstructionSet before = CurrentInstructionSet();
  for (const InstructionSet set : { InstructionSet::Generic, InstructionSet::Avx2, InstructionSet::Avx512 })
  {
    if (HasInstructionSet(set))
    {
      SetInstructionSet(set);
      body(set);
    }
  }
  SetInstructionSet(before);
}

} // namespace surfsynth::test
