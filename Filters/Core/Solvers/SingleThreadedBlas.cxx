// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SingleThreadedBlas.h"

#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <new>
#include <vector>

extern "C" {
// Present when the BLAS in use is OpenBLAS.
__attribute__((weak)) void openblas_set_num_threads(int threads);
__attribute__((weak)) int openblas_get_num_threads();
__attribute__((weak)) int openblas_get_num_procs();
__attribute__((weak)) void* blas_memory_alloc(int kind);
__attribute__((weak)) void blas_memory_free(void* buffer);
}

namespace surfsynth
{

namespace
{
std::mutex Mutex;
int Users = 0;
int ThreadsBefore = 1;
int Buffers = 0; // that OpenBLAS holds for us

/// Bytes of address space that OpenBLAS maps for a buffer: 128 MiB on x86-64, and what its alignment costs.
constexpr std::size_t BufferBytes = std::size_t{ 130 } << 20;

/// Lets OpenBLAS map a buffer for each thread that may call it. It tries forever to map one where the address space is
/// limited (RLIMIT_AS, no overcommitment of memory), so that the space is asked for here first.
void ReserveBuffers(int threads)
{
  if (!blas_memory_alloc || !blas_memory_free || !openblas_get_num_procs)
  {
    return;
  }
  const int wanted = std::min(threads, openblas_get_num_procs());
  if (wanted <= Buffers)
  {
    return;
  }
  void* volatile space = std::malloc(static_cast<std::size_t>(wanted - Buffers) * BufferBytes);
  if (!space)
  {
    throw std::bad_alloc();
  }
  std::free(space);
  std::vector<void*> held(static_cast<std::size_t>(wanted)); // all at once: a buffer that is free is used again
  std::generate(held.begin(), held.end(), [] { return blas_memory_alloc(0); });
  std::for_each(held.begin(), held.end(), blas_memory_free);
  Buffers = wanted;
}
} // namespace

SingleThreadedBlas::SingleThreadedBlas()
{
  std::lock_guard<std::mutex> lock(Mutex);
  ReserveBuffers(MaximumThreads());
  if (Users++ == 0 && openblas_set_num_threads && openblas_get_num_threads)
  {
    ThreadsBefore = openblas_get_num_threads();
    openblas_set_num_threads(1);
  }
}

SingleThreadedBlas::~SingleThreadedBlas()
{
  std::lock_guard<std::mutex> lock(Mutex);
  if (--Users == 0 && openblas_set_num_threads)
  {
    openblas_set_num_threads(ThreadsBefore);
  }
}

} // namespace surfsynth
