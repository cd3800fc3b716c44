// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/ProductKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const ProductKernels* BestProductKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? &Avx512ProductKernels
    : set == InstructionSet::Avx2      ? &Avx2ProductKernels
                                       : nullptr;
#else
  return nullptr;
#endif
}

} // namespace surfsynth
