// SPDX-License-Identifier: BSD-3-Clause
#include "BackgroundJob.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <utility>

namespace surfsynth
{

BackgroundJob::~BackgroundJob() { this->Stop(); }

void BackgroundJob::Start(Work work, const std::string& text)
{
  this->Stop();
  this->StopRequested = false;
  this->Stage = "running: ";
  this->Text = text;
  this->Failure = nullptr;
  this->Running = this->Pending = true;
  this->Thread = std::thread([this, work = std::move(work), threads = MaximumThreads()] { this->Run(work, threads); });
}

void BackgroundJob::Stop()
{
  this->StopRequested = true;
  if (this->Thread.joinable())
  {
    this->Thread.join();
  }
}

void BackgroundJob::Describe(const std::string& text)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Text = text;
}

void BackgroundJob::Run(const Work& work, int threads)
{
  const ThreadScope scope(threads);
  std::string end = "finished: ";
  std::exception_ptr failure;
  try
  {
    work(this->Continue);
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
  this->Stage = end;
  this->Failure = failure;
  this->Running = false;
}

bool BackgroundJob::IsPending() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Pending;
}

bool BackgroundJob::Look()
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Pending = this->Running;
  if (this->Failure)
  {
    std::rethrow_exception(this->Failure);
  }
  return !this->Running;
}

std::string BackgroundJob::State() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Stage + this->Text;
}

} // namespace surfsynth
