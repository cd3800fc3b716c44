// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/FaceKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const FaceKernels& BestFaceKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512FaceKernels
    : set == InstructionSet::Avx2      ? Avx2FaceKernels
                                       : GenericFaceKernels;
#else
  return GenericFaceKernels;
#endif
}

} // namespace surfsynth
