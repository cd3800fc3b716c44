// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SingleThreadedBlas.h"

#include <mutex>

extern "C" {
// Present when the BLAS in use is OpenBLAS.
__attribute__((weak)) void openblas_set_num_threads(int threads);
__attribute__((weak)) int openblas_get_num_threads();
}

namespace surfsynth
{

namespace
{
std::mutex Mutex;
int Users = 0;
int ThreadsBefore = 1;
} // namespace

SingleThreadedBlas::SingleThreadedBlas()
{
  std::lock_guard<std::mutex> lock(Mutex);
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
