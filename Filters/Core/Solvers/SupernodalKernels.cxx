// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SupernodalKernels.h"

#include "Core/Common/InstructionSet.h"

namespace surfsynth
{

const SupernodalKernels& BestSupernodalKernels()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? Avx512SupernodalKernels
    : set == InstructionSet::Avx2      ? Avx2SupernodalKernels
                                       : GenericSupernodalKernels;
#else
  return GenericSupernodalKernels;
#endif
}

} // namespace surfsynth
