// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Scratch memory that parallel tasks lend each other. Private to the core.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace surfsynth
{

/// Objects that tasks borrow and return, so that there are as many as threads and not as many as tasks.
template <typename T>
class ScratchPool
{
public:
  /// An object that another task has returned, else a default one.
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
