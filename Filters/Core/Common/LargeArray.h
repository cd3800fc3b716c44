// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Memory for large temporaries. Private to the core.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>

namespace surfsynth
{

/// Uninitialised memory, aligned to 64 bytes and, when it is large, on huge pages where the system offers them: the first
/// touch of a fresh small page costs more than filling it. To be given to std::free().
/// @throws std::bad_alloc
void* AllocateLarge(std::size_t bytes);
void FreeLarge(void* memory);

/// An uninitialised array of numbers in such memory.
template <typename T>
class LargeArray
{
  static_assert(std::is_trivially_copyable<T>::value, "elements are neither constructed nor destroyed");

public:
  LargeArray() = default;
  /// @throws std::bad_alloc
  explicit LargeArray(std::size_t size)
    : Size(size)
  {
    if (size > std::numeric_limits<std::size_t>::max() / sizeof(T))
    {
      throw std::bad_alloc();
    }
    this->Memory.reset(static_cast<T*>(AllocateLarge(size * sizeof(T))));
  }

  T* data() { return this->Memory.get(); }
  const T* data() const { return this->Memory.get(); }
  std::size_t size() const { return this->Size; }
  T& operator[](std::size_t k) { return this->Memory.get()[k]; }
  const T& operator[](std::size_t k) const { return this->Memory.get()[k]; }

private:
  struct Free
  {
    void operator()(T* memory) const { FreeLarge(memory); }
  };
  std::unique_ptr<T, Free> Memory;
  std::size_t Size = 0;
};

} // namespace surfsynth
