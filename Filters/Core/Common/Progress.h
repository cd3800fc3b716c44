// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Progress reports and cancellation of long calls.
#pragma once

#include <atomic>
#include <functional>

namespace surfsynth
{

/// Receives the completed fraction in [0, 1], never decreasing, always on the thread that made the long call.
/// Returns true to go on and false to stop; the long call then throws Cancelled. May be empty.
using Progress = std::function<bool(double)>;

/// Reports @p fraction; throws Cancelled when @p progress says stop. An empty callback is no report.
void Report(const Progress& progress, double fraction);

/// The callback of a step that covers [@p begin, @p end] of the whole @p progress. Empty when @p progress is.
Progress SubProgress(const Progress& progress, double begin, double end);

/// Runs @p work on a second thread and waits for it on this one, so that a call into a library which knows neither
/// progress nor cancellation does not hold up either: reports about twenty times a second a fraction that approaches
/// 1 (half of it after @p expectedSeconds).
///
/// On cancellation it throws Cancelled at once; @p work then runs to its end in the background (the process waits for it
/// before it exits), so everything it touches must be owned by the closure (capture shared pointers by value).
/// Exceptions of @p work are rethrown here.
/// With an empty @p progress, @p work simply runs on this thread.
void RunCancellable(const std::function<void()>& work, double expectedSeconds, const Progress& progress);

/// The same for work in steps: @p work gets a flag that becomes true on cancellation, so that it can end early.
void RunCancellable(
  const std::function<void(const std::atomic<bool>& stop)>& work, double expectedSeconds, const Progress& progress);

} // namespace surfsynth
