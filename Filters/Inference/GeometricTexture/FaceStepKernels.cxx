// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/FaceStepKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const FaceStepKernels& BestFaceStepKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512FaceStepKernels
    : set == InstructionSet::Avx2      ? Avx2FaceStepKernels
                                       : GenericFaceStepKernels;
#else
  return GenericFaceStepKernels;
#endif
}

} // namespace surfsynth
