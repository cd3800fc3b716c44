// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Progress.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace surfsynth
{

void Report(const Progress& progress, double fraction)
{
  if (progress && !progress(fraction))
  {
    throw Cancelled("Stopped on request.");
  }
}

Progress SubProgress(const Progress& progress, double begin, double end)
{
  if (!progress)
  {
    return {};
  }
  return [progress, begin, end](double fraction) { return progress(begin + fraction * (end - begin)); };
}

namespace
{
/// State that the waiting and the working thread share; the last of the two to let go frees it.
struct CancellableRun
{
  std::mutex Mutex;
  std::condition_variable Ended;
  bool Done = false;
  std::exception_ptr Failure;
};

/// Threads of cancelled calls. They are joined when the process ends: work that went on while the libraries it calls
/// are taken down would crash.
class AbandonedThreads
{
public:
  ~AbandonedThreads()
  {
    for (Abandoned& abandoned : this->Threads)
    {
      abandoned.Thread.join();
    }
  }
  void Add(std::thread thread, std::shared_ptr<CancellableRun> run)
  {
    std::lock_guard<std::mutex> lock(this->Mutex);
    for (auto abandoned = this->Threads.begin(); abandoned != this->Threads.end();)
    {
      abandoned = abandoned->JoinIfDone() ? this->Threads.erase(abandoned) : std::next(abandoned);
    }
    this->Threads.push_back({ std::move(thread), std::move(run) });
  }

private:
  struct Abandoned
  {
    std::thread Thread;
    std::shared_ptr<CancellableRun> Run;

    bool JoinIfDone()
    {
      {
        std::lock_guard<std::mutex> lock(this->Run->Mutex);
        if (!this->Run->Done)
        {
          return false;
        }
      }
      this->Thread.join();
      return true;
    }
  };
  std::mutex Mutex;
  std::list<Abandoned> Threads;
};

AbandonedThreads& TheAbandonedThreads()
{
  static AbandonedThreads threads;
  return threads;
}
} // namespace

void RunCancellable(const std::function<void()>& work, double expectedSeconds, const Progress& progress)
{
  if (!progress)
  {
    work();
    return;
  }
  auto run = std::make_shared<CancellableRun>();
  std::thread worker([run, work, threads = MaximumThreads()] {
    const ThreadScope scope(threads);
    std::exception_ptr failure;
    try
    {
      work();
    }
    catch (...)
    {
      failure = std::current_exception();
    }
    std::lock_guard<std::mutex> lock(run->Mutex);
    run->Failure = failure;
    run->Done = true;
    run->Ended.notify_all();
  });

  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  std::unique_lock<std::mutex> lock(run->Mutex);
  while (!run->Ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return run->Done; }))
  {
    lock.unlock();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    try
    {
      Report(progress, seconds / (seconds + expectedSeconds));
    }
    catch (...)
    {
      TheAbandonedThreads().Add(std::move(worker), run);
      throw;
    }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (run->Failure)
  {
    std::rethrow_exception(run->Failure);
  }
}

void RunCancellable(
  const std::function<void(const std::atomic<bool>& stop)>& work, double expectedSeconds, const Progress& progress)
{
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  try
  {
    RunCancellable([stop, work] { work(*stop); }, expectedSeconds, progress);
  }
  catch (const Cancelled&)
  {
    stop->store(true);
    throw;
  }
}

} // namespace surfsynth
