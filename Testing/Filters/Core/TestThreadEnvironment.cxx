// SPDX-License-Identifier: BSD-3-Clause
// Run by CTest with SURFACE_SYNTHESIS_THREADS=3 and SURFACE_SYNTHESIS_INSTRUCTION_SET=generic.
#include "Core/Common/Errors.h"
#include "Core/Common/InstructionSet.h"
#include "Core/Common/Parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

TEST(MaximumThreads, FollowsTheEnvironmentElseTheProcessors)
{
  const char* text = std::getenv("SURFACE_SYNTHESIS_THREADS");
  const int expected = text != nullptr ? std::atoi(text)
                                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_EQ(surfsynth::MaximumThreads(), expected);
  const surfsynth::ThreadScope scope(expected + 2);
  EXPECT_EQ(surfsynth::MaximumThreads(), expected + 2) << "a scope overrides the environment";
}

using surfsynth::CurrentInstructionSet;
using surfsynth::HasInstructionSet;
using surfsynth::InstructionSet;
using surfsynth::SetInstructionSet;

TEST(InstructionSetEnvironment, TheVariableChoosesAndTheFunctionGoesBeforeIt)
{
  EXPECT_EQ(CurrentInstructionSet(), InstructionSet::Generic);
  EXPECT_TRUE(HasInstructionSet(InstructionSet::Generic));
  for (const InstructionSet set : { InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Generic })
  {
    if (HasInstructionSet(set))
    {
      SetInstructionSet(set);
      EXPECT_EQ(CurrentInstructionSet(), set);
    }
    else
    {
      EXPECT_THROW(SetInstructionSet(set), surfsynth::InvalidInput);
    }
  }
}
