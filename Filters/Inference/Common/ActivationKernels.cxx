// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/ActivationKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const ActivationKernels& BestActivationKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512ActivationKernels
    : set == InstructionSet::Avx2      ? Avx2ActivationKernels
                                       : GenericActivationKernels;
#else
  return GenericActivationKernels;
#endif
}

} // namespace surfsynth
