// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Limit of the BLAS to one thread. Private to the library.
#pragma once

namespace surfsynth
{

/// Keeps OpenBLAS on the calling thread while at least one object lives: the library distributes work itself, and
/// results must not depend on the number of threads of the BLAS. No effect on other BLAS.
class SingleThreadedBlas
{
public:
  /// Begins the limit. Throws std::bad_alloc where the address space holds no buffer of OpenBLAS for each thread.
  SingleThreadedBlas();
  /// Ends the limit when no other object lives.
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

} // namespace surfsynth
