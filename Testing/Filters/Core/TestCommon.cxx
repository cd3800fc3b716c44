// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/Progress.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

using namespace surfsynth;

namespace
{

double SecondsSince(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

// --- Errors -----------------------------------------------------------------------------------------------------

TEST(Errors, EveryKindIsAnErrorAndKeepsItsText)
{
  const auto textOf = [](const auto& error) {
    try
    {
      throw error;
    }
    catch (const Error& caught)
    {
      return std::string(caught.what());
    }
  };
  EXPECT_EQ(textOf(InvalidInput("a")), "a");
  EXPECT_EQ(textOf(SolverFailure("b")), "b");
  EXPECT_EQ(textOf(FormatError("c")), "c");
  EXPECT_EQ(textOf(ModelMismatch("d")), "d");
  EXPECT_EQ(textOf(Cancelled("e")), "e");
  EXPECT_THROW(throw InvalidInput("f"), std::runtime_error);
}

// --- Progress ---------------------------------------------------------------------------------------------------

TEST(Progress, ReportPassesTheFractionOn)
{
  double seen = -1.0;
  Report(
    [&](double fraction) {
      seen = fraction;
      return true;
    },
    0.25);
  EXPECT_EQ(seen, 0.25);
}

TEST(Progress, ReportThrowsCancelledWhenToldToStop)
{
  EXPECT_THROW(Report([](double) { return false; }, 0.5), Cancelled);
}

TEST(Progress, EmptyCallbacksReportNothing)
{
  EXPECT_NO_THROW(Report({}, 0.5));
  EXPECT_FALSE(static_cast<bool>(SubProgress({}, 0.0, 1.0)));
}

TEST(Progress, SubProgressMapsZeroToOneOntoItsRange)
{
  std::vector<double> seen;
  const Progress whole = [&](double fraction) {
    seen.push_back(fraction);
    return true;
  };
  const Progress second = SubProgress(whole, 0.25, 0.75);
  const Progress nested = SubProgress(second, 0.5, 1.0);
  for (const double fraction : { 0.0, 0.5, 1.0 })
  {
    EXPECT_TRUE(second(fraction));
    EXPECT_TRUE(nested(fraction));
  }
  EXPECT_EQ(seen, (std::vector<double>{ 0.25, 0.5, 0.5, 0.625, 0.75, 0.75 }));
}

TEST(Progress, SubProgressPassesTheWishToStopOn)
{
  EXPECT_FALSE(SubProgress([](double) { return false; }, 0.0, 0.5)(0.1));
}

TEST(RunCancellable, WithoutProgressWorksOnTheCallingThread)
{
  std::thread::id worker;
  RunCancellable([&] { worker = std::this_thread::get_id(); }, 1.0, {});
  EXPECT_EQ(worker, std::this_thread::get_id());
}

TEST(RunCancellable, ReportsRisingFractionsOnTheCallingThread)
{
  std::vector<double> seen;
  bool onCaller = true;
  const std::thread::id caller = std::this_thread::get_id();
  RunCancellable([] { std::this_thread::sleep_for(std::chrono::milliseconds(600)); }, 0.3,
    [&](double fraction) {
      seen.push_back(fraction);
      onCaller = onCaller && std::this_thread::get_id() == caller;
      return true;
    });
  EXPECT_TRUE(onCaller);
  ASSERT_GE(seen.size(), 5U) << "about twenty reports a second are promised";
  for (std::size_t i = 0; i < seen.size(); ++i)
  {
    EXPECT_GE(seen[i], i == 0 ? 0.0 : seen[i - 1]);
    EXPECT_LE(seen[i], 1.0);
  }
  EXPECT_GT(seen.back(), 0.5) << "more than half is reported after the expected time";
}

TEST(RunCancellable, ReturnsAtOnceOnCancelAndLeavesTheWorkToEnd)
{
  auto done = std::make_shared<std::atomic<bool>>(false);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(RunCancellable(
                 [done] {
                   std::this_thread::sleep_for(std::chrono::milliseconds(1500));
                   *done = true;
                 },
                 1.0, [](double) { return false; }),
    Cancelled);
  EXPECT_LT(SecondsSince(start), 0.75);
  EXPECT_FALSE(*done);
  while (!*done && SecondsSince(start) < 20.0)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(*done);
}

TEST(RunCancellable, RethrowsExceptionsOfTheWork)
{
  const Progress goOn = [](double) { return true; };
  EXPECT_THROW(RunCancellable([] { throw SolverFailure("pivot"); }, 1.0, goOn), SolverFailure);
  EXPECT_THROW(RunCancellable([] { throw std::bad_alloc(); }, 1.0, goOn), std::bad_alloc);
  EXPECT_THROW(RunCancellable([] { throw InvalidInput("size"); }, 1.0, {}), InvalidInput);
}

TEST(RunCancellable, KeepsTheThreadLimitOfTheCaller)
{
  const ThreadScope scope(3);
  int limit = 0;
  RunCancellable([&] { limit = MaximumThreads(); }, 1.0, [](double) { return true; });
  EXPECT_EQ(limit, 3);
}

// --- Parallel ---------------------------------------------------------------------------------------------------

TEST(ThreadScope, NestsAndClamps)
{
  const int outside = MaximumThreads();
  EXPECT_GE(outside, 1);
  {
    const ThreadScope three(3);
    EXPECT_EQ(MaximumThreads(), 3);
    {
      const ThreadScope none(-7);
      EXPECT_EQ(MaximumThreads(), 1);
    }
    EXPECT_EQ(MaximumThreads(), 3);
    int elsewhere = 0;
    std::thread([&] { elsewhere = MaximumThreads(); }).join();
    EXPECT_EQ(elsewhere, outside) << "other threads are not limited";
  }
  EXPECT_EQ(MaximumThreads(), outside);
}

TEST(ParallelFor, CoversEveryIndexOnceInConsecutiveRanges)
{
  for (const int threads : { 1, 2, 3, 8 })
  {
    const ThreadScope scope(threads);
    for (const std::int64_t count : { 0, 1, 2, 7, 100, 10007 })
    {
      for (const std::int64_t grain : { 1, 10, 1000, 100000 })
      {
        std::vector<int> visits(static_cast<std::size_t>(count), 0);
        std::set<std::pair<std::int64_t, std::int64_t>> ranges;
        std::mutex mutex;
        std::thread::id first;
        ParallelFor(count, grain, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i)
          {
            ++visits[static_cast<std::size_t>(i)];
          }
          const std::lock_guard<std::mutex> lock(mutex);
          ranges.emplace(begin, end);
          if (begin == 0)
          {
            first = std::this_thread::get_id();
          }
        });
        EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(count), 1));
        EXPECT_LE(ranges.size(), static_cast<std::size_t>(threads));
        for (const auto& range : ranges)
        {
          EXPECT_GE(range.second - range.first, std::min(grain, count)) << "ranges hold at least a grain";
        }
        if (count > 0)
        {
          EXPECT_EQ(first, std::this_thread::get_id()) << "the calling thread takes the first range";
        }
      }
    }
  }
}

TEST(ParallelFor, UsesSeveralThreadsWhenThereIsEnoughWork)
{
  const ThreadScope scope(4);
  std::set<std::thread::id> seen;
  std::mutex mutex;
  ParallelFor(4000, 1000, [&](std::int64_t, std::int64_t) {
    const std::lock_guard<std::mutex> lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(seen.size(), 4U);
}

TEST(ParallelFor, RethrowsAfterAllRangesHaveEnded)
{
  const ThreadScope scope(4);
  for (const std::int64_t failing : { 0, 50, 99 })
  {
    std::atomic<int> ended{ 0 };
    EXPECT_THROW(ParallelFor(100, 1,
                   [&](std::int64_t begin, std::int64_t end) {
                     if (begin <= failing && failing < end)
                     {
                       throw InvalidInput("this range");
                     }
                     std::this_thread::sleep_for(std::chrono::milliseconds(50));
                     ++ended;
                   }),
      InvalidInput);
    EXPECT_EQ(ended, 3);
  }
}

TEST(ParallelTasks, RunsEveryTaskOnce)
{
  for (const int threads : { 1, 2, 5 })
  {
    const ThreadScope scope(threads);
    for (const std::int64_t count : { 0, 1, 3, 200 })
    {
      std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
      ParallelTasks(count, [&](std::int64_t k) { ++visits[static_cast<std::size_t>(k)]; });
      for (const auto& visit : visits)
      {
        EXPECT_EQ(visit, 1);
      }
    }
  }
}

TEST(ParallelTasks, BeatsOnTheCallingThreadAfterEachOfItsTasks)
{
  const ThreadScope scope(1);
  int beats = 0;
  bool onCaller = true;
  const std::thread::id caller = std::this_thread::get_id();
  ParallelTasks(
    20, [](std::int64_t) {},
    [&] {
      ++beats;
      onCaller = onCaller && std::this_thread::get_id() == caller;
    });
  EXPECT_EQ(beats, 20);
  EXPECT_TRUE(onCaller);
}

TEST(ParallelTasks, StopsWhenTheHeartbeatThrows)
{
  for (const int threads : { 1, 3 })
  {
    const ThreadScope scope(threads);
    std::atomic<int> started{ 0 };
    EXPECT_THROW(ParallelTasks(
                   1000,
                   [&](std::int64_t) {
                     ++started;
                     std::this_thread::sleep_for(std::chrono::milliseconds(2));
                   },
                   [] { throw Cancelled("enough"); }),
      Cancelled);
    EXPECT_LT(started, 100);
  }
}

TEST(ParallelTasks, RethrowsExceptionsOfTasks)
{
  const ThreadScope scope(3);
  EXPECT_THROW(ParallelTasks(50,
                 [](std::int64_t k) {
                   if (k == 31)
                   {
                     throw SolverFailure("task 31");
                   }
                 }),
    SolverFailure);
}
