// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/GradientKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const GradientKernels& BestGradientKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512GradientKernels
    : set == InstructionSet::Avx2      ? Avx2GradientKernels
                                       : GenericGradientKernels;
#else
  return GenericGradientKernels;
#endif
}

} // namespace surfsynth
