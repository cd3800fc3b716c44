// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SupernodalKernels.h"

namespace surfsynth
{

const SupernodalKernels& BestSupernodalKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  static const SupernodalKernels& best = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")
    ? Avx512SupernodalKernels
    : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? Avx2SupernodalKernels
                                                                      : GenericSupernodalKernels;
  return best;
#else
  return GenericSupernodalKernels;
#endif
}

} // namespace surfsynth
