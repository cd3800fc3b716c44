// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace surfsynth
{

namespace
{
/// Threads asked for by the innermost ThreadScope of this thread; 0 outside of any.
thread_local int ScopedThreads = 0;

int DefaultThreads()
{
  static const int threads = [] {
    const char* text = std::getenv("SURFACE_SYNTHESIS_THREADS");
    const long asked = text ? std::strtol(text, nullptr, 10) : 0;
    const long available = static_cast<long>(std::thread::hardware_concurrency());
    return static_cast<int>(std::clamp(asked > 0 ? asked : available, 1L, 1024L));
  }();
  return threads;
}

/// Keeps the first exception that any thread throws.
class FirstFailure
{
public:
  void Catch(const std::function<void()>& work)
  {
    try
    {
      work();
    }
    catch (...)
    {
      std::lock_guard<std::mutex> lock(this->Mutex);
      if (!this->Failure)
      {
        this->Failure = std::current_exception();
      }
    }
  }
  void Rethrow() const
  {
    if (this->Failure)
    {
      std::rethrow_exception(this->Failure);
    }
  }

private:
  std::mutex Mutex;
  std::exception_ptr Failure;
};

/// The helper threads of one parallel loop, and the number of those that still run.
class Helpers
{
public:
  ~Helpers()
  {
    for (std::thread& thread : this->Threads)
    {
      thread.join();
    }
  }
  /// Runs @p work on a thread of its own, which may not go parallel again.
  void Start(const std::function<void()>& work)
  {
    ++this->Running;
    try
    {
      this->Threads.emplace_back([this, work] {
        const ThreadScope alone(1);
        work();
        std::lock_guard<std::mutex> lock(this->Mutex);
        --this->Running;
        this->Ended.notify_all();
      });
    }
    catch (...)
    {
      --this->Running;
      throw;
    }
  }
  /// Waits until all have ended, calling @p heartbeat about twenty times a second.
  void Wait(const std::function<void()>& heartbeat)
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    while (!this->Ended.wait_for(lock, std::chrono::milliseconds(50), [this] { return this->Running == 0; }))
    {
      lock.unlock();
      heartbeat();
      lock.lock();
    }
  }

private:
  std::vector<std::thread> Threads;
  std::mutex Mutex;
  std::condition_variable Ended;
  std::atomic<int> Running{ 0 };
};

/// Runs work(t) for t in [0, threads): t = 0 here, the others each on a thread of their own. @p heartbeat is called on
/// this thread while it waits for the others.
void RunOnThreads(int threads, const std::function<void(int)>& work, const std::function<void()>& heartbeat)
{
  FirstFailure failure;
  {
    Helpers helpers;
    failure.Catch([&] {
      for (int t = 1; t < threads; ++t)
      {
        helpers.Start([&failure, &work, t] { failure.Catch([&] { work(t); }); });
      }
      work(0);
      if (heartbeat)
      {
        helpers.Wait(heartbeat);
      }
    });
  }
  failure.Rethrow();
}
} // namespace

int MaximumThreads() { return ScopedThreads > 0 ? ScopedThreads : DefaultThreads(); }

ThreadScope::ThreadScope(int threads)
  : Previous(ScopedThreads)
{
  ScopedThreads = std::max(threads, 1);
}

ThreadScope::~ThreadScope() { ScopedThreads = this->Previous; }

void ParallelFor(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body)
{
  if (count <= 0)
  {
    return;
  }
  const std::int64_t ranges = std::clamp<std::int64_t>(count / std::max<std::int64_t>(grain, 1), 1, MaximumThreads());
  if (ranges == 1)
  {
    body(0, count);
    return;
  }
  RunOnThreads(static_cast<int>(ranges), [&](int t) { body(count * t / ranges, count * (t + 1) / ranges); }, {});
}

void ParallelTasks(
  std::int64_t count, const std::function<void(std::int64_t)>& task, const std::function<void()>& heartbeat)
{
  std::atomic<std::int64_t> next{ 0 };
  const int threads = static_cast<int>(std::clamp<std::int64_t>(count, 1, MaximumThreads()));
  const auto takeTasks = [&](int t) {
    try
    {
      for (std::int64_t k = next++; k < count; k = next++)
      {
        task(k);
        if (t == 0 && heartbeat)
        {
          heartbeat();
        }
      }
    }
    catch (...)
    {
      next = count;
      throw;
    }
  };
  RunOnThreads(threads, takeTasks, heartbeat);
}

} // namespace surfsynth
