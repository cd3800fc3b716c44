// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Memory for large temporaries. Private to the core.
#pragma once

#include <cstddef>
#include <memory>

namespace surfsynth
{

/// An uninitialised array of doubles, aligned to 64 bytes and, when it is large, on huge pages where the system offers
/// them: the first touch of a fresh small page costs more than filling it.
class LargeArray
{
public:
  LargeArray() = default;
  /// @throws std::bad_alloc
  explicit LargeArray(std::size_t size);

  double* data() { return this->Memory.get(); }
  const double* data() const { return this->Memory.get(); }
  std::size_t size() const { return this->Size; }

private:
  struct Free
  {
    void operator()(double* memory) const;
  };
  std::unique_ptr<double[], Free> Memory;
  std::size_t Size = 0;
};

} // namespace surfsynth
