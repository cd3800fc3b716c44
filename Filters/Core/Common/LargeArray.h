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

/// Allocates uninitialised memory, aligned to 64 bytes. A large block lies on huge pages where the system offers them:
/// the first touch of a fresh small page costs more than filling it.
/// @return memory for FreeLarge()
/// @throws std::bad_alloc
void* AllocateLarge(std::size_t bytes);
/// Frees memory of AllocateLarge(); null does nothing.
void FreeLarge(void* memory);

/// Uninitialised array of numbers in memory of AllocateLarge(). Can be moved, not copied.
template <typename T>
class LargeArray
{
  static_assert(std::is_trivially_copyable<T>::value, "elements are neither constructed nor destroyed");

public:
  /// Makes an empty array.
  LargeArray() = default;
  /// Makes an array of @p size uninitialised elements.
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

  /// First element; null for an empty array.
  T* data() { return this->Memory.get(); }
  /// First element; null for an empty array.
  const T* data() const { return this->Memory.get(); }
  /// Number of elements.
  std::size_t size() const { return this->Size; }
  /// Element @p k, below size(); not checked.
  T& operator[](std::size_t k) { return this->Memory.get()[k]; }
  /// Element @p k, below size(); not checked.
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
