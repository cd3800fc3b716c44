// SPDX-License-Identifier: BSD-3-Clause
// Run by CTest with SURFACE_SYNTHESIS_THREADS=3.
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
