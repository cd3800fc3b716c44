// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Random/CounterUniforms.h"

#include <Random123/philox.h>

namespace surfsynth
{

double Uniform(const NormalKey& key, std::int64_t point)
{
  constexpr std::uint64_t AnotherKey = 0x756e69666f726d73; // any number that is not 0
  const std::uint64_t seed = key.Seed ^ AnotherKey;
  const philox4x32_key_t philoxKey = { { static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32) } };
  const philox4x32_ctr_t counter = { { static_cast<std::uint32_t>(point / 4), key.Component, key.Sample, key.Stream } };
  return philox4x32_R(10, counter, philoxKey).v[point % 4] * 0x1p-32;
}

std::int64_t UniformIndex(const NormalKey& key, std::int64_t point, std::int64_t count)
{
  return static_cast<std::int64_t>(Uniform(key, point) * static_cast<double>(count));
}

} // namespace surfsynth
