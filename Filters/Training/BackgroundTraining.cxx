// SPDX-License-Identifier: BSD-3-Clause
#include "BackgroundTraining.h"

#include <utility>

namespace surfsynth
{

void BackgroundTraining::Start(TrainingJob job)
{
  this->Stop();
  this->Report = BackgroundReport();
  this->Job.Start([this, job = std::move(job)](const Progress&) { job(*this); }, "before the first iteration");
}

BackgroundReport BackgroundTraining::Look()
{
  this->Job.Look();
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Report;
}

void BackgroundTraining::Note(const LossHistory& history, const std::string& stage)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  LossHistory& kept = this->Report.History;
  if (history.Size() == kept.Size() + 1 && history.Columns() == kept.Columns())
  {
    kept.Append(history.Row(history.Size() - 1));
  }
  else
  {
    kept = history; // the first, or that of another stage
  }
  this->Clock.Add(history);
  this->Job.Describe(stage + this->Clock.Describe());
  this->Report.SecondsLeft = this->Clock.SecondsLeft();
}

TrainingObserver BackgroundTraining::ShowProgress(const TrainingClock& clock, const std::string& stage)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Clock = clock;
  return [this, stage](const LossHistory& history) {
    this->Note(history, stage);
    return !this->Job.IsStopRequested();
  };
}

bool BackgroundTraining::EndsEarly(const ModelTrainer& trainer, const std::string&)
{
  return trainer.Iteration() < trainer.Iterations();
}

void BackgroundTraining::Finish(const ModelTrainer& trainer)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Report.History = trainer.History();
  this->Report.Device = trainer.DeviceName();
}

} // namespace surfsynth
