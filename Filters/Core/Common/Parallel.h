// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Data parallelism for loops whose iterations write to disjoint places.
#pragma once

#include <cstdint>
#include <functional>

namespace surfsynth
{

/// Number of threads that loops started from the calling thread may use: the innermost ThreadScope, else the
/// environment variable SURFACE_SYNTHESIS_THREADS, else the number of processors. At least 1.
int MaximumThreads();

/// Limits MaximumThreads() of the calling thread to @p threads (clamped to at least 1) while the object lives.
class ThreadScope
{
public:
  /// Begins the limit.
  explicit ThreadScope(int threads);
  /// Restores the limit from before.
  ~ThreadScope();
  ThreadScope(const ThreadScope&) = delete;
  ThreadScope& operator=(const ThreadScope&) = delete;

private:
  int Previous;
};

/// Calls body(begin, end) on consecutive ranges that cover [0, @p count), each of at least @p grain items, at most one
/// range per thread; the calling thread takes the first range. The result of an item must not depend on the range it
/// falls in: then results are the same for every number of threads.
/// @throws the first exception of a body, after all ranges have ended.
void ParallelFor(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body);

/// Calls task(k) once for every k in [0, @p count), on up to MaximumThreads() threads that take the next k when free
/// (for tasks of unequal cost). The calling thread calls @p heartbeat after each of its own tasks, and about twenty
/// times a second while it only waits for the others; when that throws, no further task starts and the exception is
/// rethrown once the running ones have ended.
void ParallelTasks(
  std::int64_t count, const std::function<void(std::int64_t)>& task, const std::function<void()>& heartbeat = {});

} // namespace surfsynth
