// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const LatentDiffusionKernels& BestLatentDiffusionKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512LatentDiffusionKernels
    : set == InstructionSet::Avx2      ? Avx2LatentDiffusionKernels
                                       : GenericLatentDiffusionKernels;
#else
  return GenericLatentDiffusionKernels;
#endif
}

} // namespace surfsynth
