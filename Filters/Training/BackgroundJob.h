// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Work on a thread of its own that updates look after. Private to the module.
#pragma once

#include "Core/Common/Progress.h"

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace surfsynth
{

/// Work in the background, with the threads for loops of the thread that starts it. One thread starts, stops and looks.
class BackgroundJob
{
public:
  /// Work: ends with Cancelled when the progress that it is given returns false.
  using Work = std::function<void(const Progress& progress)>;

  BackgroundJob() = default;
  /// Stops.
  ~BackgroundJob();
  BackgroundJob(const BackgroundJob&) = delete;
  BackgroundJob& operator=(const BackgroundJob&) = delete;

  /// Starts @p work, after Stop(); Describe(@p text) comes first. @p work owns or outlives whatever it uses.
  void Start(Work work, const std::string& text);
  /// Asks the work to stop, and waits for its end.
  void Stop();
  /// True once Stop() has been called since the start.
  bool IsStopRequested() const { return this->StopRequested; }
  /// The progress that the work is given.
  const Progress& GetProgress() const { return this->Continue; }
  /// Sets the description of the state. Any thread.
  void Describe(const std::string& text);

  /// True from Start() until Look() has been called after the end.
  bool IsPending() const;
  /// Rethrows the error of the work. Returns true when it has ended; it is no longer pending then.
  bool Look();
  /// "running: ", "finished: ", "stopped: " or "failed: " and the description; empty before the first start.
  std::string State() const;

private:
  void Run(const Work& work, int threads);

  std::thread Thread;
  std::atomic<bool> StopRequested{ false };
  Progress Continue = [this](double) { return !this->StopRequested; };
  mutable std::mutex Mutex; ///< of all below
  std::string Stage;        ///< "running: " and so on
  std::string Text;
  std::exception_ptr Failure;
  bool Running = false;
  bool Pending = false;
};

} // namespace surfsynth
