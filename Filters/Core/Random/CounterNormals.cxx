// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Random/CounterNormals.h"

#include "Core/Common/InstructionSet.h"
#include "Core/Random/NormalBlocks.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
constexpr std::int64_t PointsAtOnce = 4 * NormalBlocksAtOnce;

using FillFunction = void (*)(const NormalKey&, std::uint32_t, double*);

/// The variant for CurrentInstructionSet().
FillFunction BestFill()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  const InstructionSet set = CurrentInstructionSet();
  return set == InstructionSet::Avx512 ? FillNormalBlocksAvx512
    : set == InstructionSet::Avx2      ? FillNormalBlocksAvx2
                                       : FillNormalBlocksGeneric;
#else
  return FillNormalBlocksGeneric;
#endif
}
} // namespace

void FillNormals(const NormalKey& key, std::int64_t first, std::int64_t count, double* out)
{
  const FillFunction fill = BestFill();
  auto block = static_cast<std::uint32_t>(first / 4);
  for (; count >= PointsAtOnce; count -= PointsAtOnce, out += PointsAtOnce, block += NormalBlocksAtOnce)
  {
    fill(key, block, out);
  }
  if (count > 0)
  {
    double last[PointsAtOnce];
    fill(key, block, last);
    std::copy_n(last, count, out);
  }
}

double Normal(const NormalKey& key, std::int64_t point)
{
  double normals[PointsAtOnce];
  BestFill()(key, static_cast<std::uint32_t>(point / 4), normals);
  return normals[point % 4];
}

} // namespace surfsynth
