// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const FieldLatentKernels& BestFieldLatentKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512FieldLatentKernels
    : set == InstructionSet::Avx2      ? Avx2FieldLatentKernels
                                       : GenericFieldLatentKernels;
#else
  return GenericFieldLatentKernels;
#endif
}

} // namespace surfsynth
