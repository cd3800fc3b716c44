// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Trainings within an update, and in the background. Private to the module.
#pragma once

#include "Core/Common/Progress.h"
#include "Learning/Training/LossHistory.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace surfsynth
{

/// Receiver of the reports of a training.
class TrainingWatch
{
public:
  virtual ~TrainingWatch() = default;

  /// Returns the observer of a stage, which @p clock follows; the watch must outlive it. @param stage comes before its texts.
  virtual TrainingObserver ShowProgress(const TrainingClock& clock, const std::string& stage = "") = 0;
  virtual const Progress& GetProgress() const = 0;
  /// True when the time budget has ended the training before its last iteration. @param what is trained, for the warning.
  virtual bool EndsEarly(const ModelTrainer& trainer, const std::string& what) = 0;
  /// Takes the results of the last stage.
  virtual void Finish(const ModelTrainer& trainer) = 0;
};

/// All stages of a training, without VTK; owns what it reads.
using TrainingJob = std::function<void(TrainingWatch& watch)>;

/// Reports of a training in the background so far.
struct BackgroundReport
{
  LossHistory History;
  std::string Device; ///< empty before the end
  std::string
    State; ///< "running: iteration 3 of 10, ...", "finished: ...", "stopped: ...", "failed: ..."; empty for none
  double SecondsLeft = 0.0;
  std::exception_ptr Failure;
};

/// A training on a thread of its own, with the threads for loops of the one that starts it.
class BackgroundTraining final : public TrainingWatch
{
public:
  BackgroundTraining() = default;
  /// Stops.
  ~BackgroundTraining() override;
  BackgroundTraining(const BackgroundTraining&) = delete;
  BackgroundTraining& operator=(const BackgroundTraining&) = delete;

  /// Starts @p job, after Stop().
  void Start(TrainingJob job);
  /// Asks the training to stop, and waits until it has written its files: at most one iteration and the preparation.
  void Stop();
  /// True from Start() until Look() has returned the report after the end.
  bool IsPending() const;
  /// Returns the report; after the end, the training is no longer pending.
  BackgroundReport Look();
  /// Returns the state of the report.
  std::string State() const;

  TrainingObserver ShowProgress(const TrainingClock& clock, const std::string& stage) override;
  const Progress& GetProgress() const override { return this->Continue; }
  bool EndsEarly(const ModelTrainer& trainer, const std::string& what) override;
  void Finish(const ModelTrainer& trainer) override;

private:
  void Run(const TrainingJob& job, int threads);
  void Note(const LossHistory& history, const std::string& stage);

  std::thread Thread;
  std::atomic<bool> StopRequested{ false };
  Progress Continue = [this](double) { return !this->StopRequested; };
  mutable std::mutex Mutex; ///< of all below
  BackgroundReport Report;
  TrainingClock Clock{ 0 };
  std::string Text;
  bool Running = false;
  bool Pending = false;
};

} // namespace surfsynth
