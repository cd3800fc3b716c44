// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/ActivationKernels.h"

namespace surfsynth
{

const ActivationKernels& BestActivationKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  static const ActivationKernels& best = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")
    ? Avx512ActivationKernels
    : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? Avx2ActivationKernels
                                                                      : GenericActivationKernels;
  return best;
#else
  return GenericActivationKernels;
#endif
}

} // namespace surfsynth
