// SPDX-License-Identifier: BSD-3-Clause
#include "BackgroundTraining.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <utility>

namespace surfsynth
{

BackgroundTraining::~BackgroundTraining() { this->Stop(); }

void BackgroundTraining::Start(TrainingJob job)
{
  this->Stop();
  this->StopRequested = false;
  this->Report = BackgroundReport();
  this->Report.State = "running: preparation";
  this->Text = "before the first iteration";
  this->Running = this->Pending = true;
  this->Thread = std::thread([this, job = std::move(job), threads = MaximumThreads()] { this->Run(job, threads); });
}

void BackgroundTraining::Stop()
{
  this->StopRequested = true;
  if (this->Thread.joinable())
  {
    this->Thread.join();
  }
}

void BackgroundTraining::Run(const TrainingJob& job, int threads)
{
  const ThreadScope scope(threads);
  std::string end = "finished: ";
  std::exception_ptr failure;
  try
  {
    job(*this);
  }
  catch (const Cancelled&)
  {
    end = "stopped: ";
  }
  catch (...)
  {
    end = "failed: ";
    failure = std::current_exception();
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Report.State = end + this->Text;
  this->Report.Failure = failure;
  this->Running = false;
}

bool BackgroundTraining::IsPending() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Pending;
}

BackgroundReport BackgroundTraining::Look()
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Pending = this->Running;
  return this->Report;
}

std::string BackgroundTraining::State() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Report.State;
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
  this->Text = stage + this->Clock.Describe();
  this->Report.State = "running: " + this->Text;
  this->Report.SecondsLeft = this->Clock.SecondsLeft();
}

TrainingObserver BackgroundTraining::ShowProgress(const TrainingClock& clock, const std::string& stage)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Clock = clock;
  return [this, stage](const LossHistory& history) {
    this->Note(history, stage);
    return !this->StopRequested;
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
