// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/FaceKernels.h"

namespace surfsynth
{

const FaceKernels& BestFaceKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  static const FaceKernels& best = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")
    ? Avx512FaceKernels
    : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? Avx2FaceKernels
                                                                      : GenericFaceKernels;
  return best;
#else
  return GenericFaceKernels;
#endif
}

} // namespace surfsynth
