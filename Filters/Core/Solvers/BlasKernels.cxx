// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/BlasKernels.h"

#include <algorithm>
#include <array>

// Present when the BLAS in use is OpenBLAS.
extern "C" __attribute__((weak)) char* openblas_get_corename();

namespace surfsynth
{

namespace
{
bool HasAvx512()
{
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
    __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}
} // namespace

std::string WiderBlasKernels()
{
  // What OpenBLAS falls back to for processors that are newer than itself.
  static const std::array<std::string, 4> narrow = { "Haswell", "Zen", "Sandybridge", "Prescott" };
  if (!openblas_get_corename || !HasAvx512() ||
    std::find(narrow.begin(), narrow.end(), openblas_get_corename()) == narrow.end())
  {
    return "";
  }
  return "SKYLAKEX";
}

} // namespace surfsynth
