// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Progress reports and cancellation of long calls.
#pragma once

#include <atomic>
#include <functional>

namespace surfsynth
{

/// Callback of a long call. Receives the completed fraction in [0, 1], never decreasing, always on the thread that made
/// the call. Returns true to go on and false to stop; the long call then throws Cancelled. May be empty.
using Progress = std::function<bool(double)>;

/// Reports @p fraction, in [0, 1]; does nothing when @p progress is empty.
/// @throws Cancelled when @p progress returns false.
void Report(const Progress& progress, double fraction);

/// The callback of a step that covers [@p begin, @p end] of the whole @p progress. Empty when @p progress is.
Progress SubProgress(const Progress& progress, double begin, double end);

/// Runs @p work on a second thread and waits for it on this one: for calls into libraries without progress reports and
/// cancellation. Reports about twenty times a second a fraction that approaches 1 (half of it after
/// @p expectedSeconds). With an empty @p progress, @p work runs on this thread.
///
/// On cancellation it throws Cancelled at once; @p work then runs to its end in the background (the process waits for
/// it before it exits), so everything it touches must be owned by the closure (capture shared pointers by value).
/// @throws Cancelled, and the exceptions of @p work.
void RunCancellable(const std::function<void()>& work, double expectedSeconds, const Progress& progress);

/// Runs work in steps like the function above: @p work gets a flag that becomes true on cancellation, to end early.
void RunCancellable(
  const std::function<void(const std::atomic<bool>& stop)>& work, double expectedSeconds, const Progress& progress);

} // namespace surfsynth
