// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Trainings within an update, and in the background. Private to the module.
#pragma once

#include "BackgroundJob.h"

#include "Core/Common/Progress.h"
#include "Learning/Training/LossHistory.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <functional>
#include <mutex>
#include <string>

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
  double SecondsLeft = 0.0;
};

/// A training on a thread of its own, with the threads for loops of the one that starts it.
class BackgroundTraining final : public TrainingWatch
{
public:
  /// Starts @p job, after Stop().
  void Start(TrainingJob job);
  /// Asks the training to stop, and waits until it has written its files: at most one iteration and the preparation.
  void Stop() { this->Job.Stop(); }
  /// True from Start() until Look() has been called after the end.
  bool IsPending() const { return this->Job.IsPending(); }
  /// Returns the report; after the end, the training is no longer pending. @throws the error of the training.
  BackgroundReport Look();
  /// Returns "running: iteration 3 of 10, ...", "finished: ...", "stopped: ..." or "failed: ..."; empty before a start.
  std::string State() const { return this->Job.State(); }

  TrainingObserver ShowProgress(const TrainingClock& clock, const std::string& stage) override;
  const Progress& GetProgress() const override { return this->Job.GetProgress(); }
  bool EndsEarly(const ModelTrainer& trainer, const std::string& what) override;
  void Finish(const ModelTrainer& trainer) override;

private:
  void Note(const LossHistory& history, const std::string& stage);

  mutable std::mutex Mutex; ///< of Report and Clock
  BackgroundReport Report;
  TrainingClock Clock{ 0 };
  BackgroundJob Job; ///< ends first
};

} // namespace surfsynth
