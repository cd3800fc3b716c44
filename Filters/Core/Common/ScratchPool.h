// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pool of scratch memory for parallel tasks. Private to the library.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace surfsynth
{

/// Pool of objects that tasks borrow and return: there are as many objects as threads, not as many as tasks. Safe to
/// use from several threads.
template <typename T>
class ScratchPool
{
public:
  /// Returns an object that another task has returned, else a default one.
  T Borrow()
  {
    std::lock_guard<std::mutex> lock(this->Mutex);
    if (this->Idle.empty())
    {
      return T();
    }
    T scratch = std::move(this->Idle.back());
    this->Idle.pop_back();
    return scratch;
  }
  /// Gives an object of Borrow() back to the pool.
  void Return(T scratch)
  {
    std::lock_guard<std::mutex> lock(this->Mutex);
    this->Idle.push_back(std::move(scratch));
  }

private:
  std::mutex Mutex;
  std::vector<T> Idle;
};

} // namespace surfsynth
