// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Random/CounterNormals.h"

#include "Core/Random/NormalBlocks.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
constexpr std::int64_t PointsAtOnce = 4 * NormalBlocksAtOnce;

using FillFunction = void (*)(const NormalKey&, std::uint32_t, double*);

/// The variant for the widest vectors that this processor has.
FillFunction BestFill()
{
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  static const FillFunction best = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")
    ? FillNormalBlocksAvx512
    : __builtin_cpu_supports("avx2") ? FillNormalBlocksAvx2
                                     : FillNormalBlocksGeneric;
  return best;
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
