// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticSamples.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/SharedProgress.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <cstdint>
#include <string>

namespace surfsynth
{

namespace
{
/// Parts of a sample in which its progress is counted.
constexpr std::int64_t WorkOfSample = 1000;
} // namespace

std::vector<ElasticEquilibrium> SettleSamples(
  int count, int first, const SampleMotion& settle, const Progress& progress)
{
  std::vector<ElasticEquilibrium> states(static_cast<std::size_t>(count));
  const SingleThreadedBlas oneThread;
  SharedProgress shared(progress, WorkOfSample * count);
  const auto settleOne = [&](std::int64_t k) {
    std::int64_t done = 0;
    const auto advance = [&shared, &done](double fraction) {
      const auto now = static_cast<std::int64_t>(fraction * WorkOfSample);
      shared.Advance(now - done);
      done = now;
      return true;
    };
    try
    {
      states[static_cast<std::size_t>(k)] = settle(static_cast<int>(k), advance);
    }
    catch (const SolverFailure& error)
    {
      throw SolverFailure("Sample " + std::to_string(first + k) + ": " + error.what());
    }
  };
  ParallelTasks(count, settleOne, [&shared] { shared.Advance(0); });
  Report(progress, 1.0);
  return states;
}

} // namespace surfsynth
