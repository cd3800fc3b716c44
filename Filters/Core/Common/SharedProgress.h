// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Progress and cancellation of work on several threads. Private to the library.
#pragma once

#include "Core/Common/Progress.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

namespace surfsynth
{

/// Sum of the work of all threads. The thread that constructed the object reports it; when the callback asks to stop,
/// all threads stop.
class SharedProgress
{
public:
  /// @param progress callback, kept by reference
  /// @param total sum of the work of all calls of Advance()
  SharedProgress(const Progress& progress, std::int64_t total)
    : Callback(progress)
    , Total(total)
  {}

  /// Adds @p work that is done. Every thread calls it several times a second, with 0 while it only waits.
  /// @throws Cancelled
  void Advance(std::int64_t work);

private:
  void ReportDone(std::int64_t done);

  using Clock = std::chrono::steady_clock;

  const Progress& Callback;
  const std::int64_t Total;
  const std::thread::id Reporter = std::this_thread::get_id();
  std::atomic<std::int64_t> Done{ 0 };
  std::atomic<bool> Stopped{ false };
  std::int64_t LastReportedDone = 0;
  Clock::time_point LastReport = Clock::now();
};

} // namespace surfsynth
