// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Progress and cancellation of work that several threads do. Private to the core.
#pragma once

#include "Core/Common/Progress.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

namespace surfsynth
{

/// Adds up what all threads have done; the thread that made it reports, and when that one is told to stop, all do.
class SharedProgress
{
public:
  /// @param total what the calls of Advance() will add up to.
  SharedProgress(const Progress& progress, std::int64_t total)
    : Callback(progress)
    , Total(total)
  {}

  /// To be called several times a second on every thread, with 0 while it only waits.
  /// @throws Cancelled
  void Advance(std::int64_t work);

private:
  void Tell(std::int64_t done);

  using Clock = std::chrono::steady_clock;

  const Progress& Callback;
  const std::int64_t Total;
  const std::thread::id Reporter = std::this_thread::get_id();
  std::atomic<std::int64_t> Done{ 0 };
  std::atomic<bool> Stopped{ false };
  std::int64_t DoneWhenTold = 0;
  Clock::time_point LastTold = Clock::now();
};

} // namespace surfsynth
