// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the FillNormalBlocks variants, included once for each instruction set by a file that defines
/// SURFSYNTH_FILL_BLOCKS (name of the function to define).
///
/// The loops are plain so that compilers turn them into vector code. Every operation is written out, and contracting a
/// product and a sum into one rounding (which compilers may do where the processor has such an instruction) is off, so
/// that the bits are the same everywhere: see the flags in CMakeLists.txt. Calls no inline function with external
/// linkage: the linker might keep the copy that was compiled for the wide instruction set for everybody.
#pragma once

#include "Core/Random/NormalBlocks.h"

#include <Random123/philox.h>

namespace surfsynth
{

namespace
{
constexpr int Count = NormalBlocksAtOnce;

std::uint64_t Bits(double value)
{
  std::uint64_t bits;
  __builtin_memcpy(&bits, &value, sizeof(bits));
  return bits;
}

double FromBits(std::uint64_t bits)
{
  double value;
  __builtin_memcpy(&value, &bits, sizeof(value));
  return value;
}

/// -2 log(u) for u in (0, 1): split u = 2^e m with m in [sqrt(1/2), sqrt(2)), then the odd series of
/// log m = 2 artanh(s), s = (m - 1) / (m + 1), |s| < 0.1716, to s^21.
double MinusTwoLog(double u)
{
  std::uint64_t bits = Bits(u);
  // Adding the difference between 1 and sqrt(1/2) carries into the exponent exactly when m >= sqrt(1/2).
  bits += 0x3FF0000000000000ULL - 0x3FE6A09E667F3BCDULL;
  const double exponent = static_cast<double>(static_cast<std::int32_t>(bits >> 52) - 1023);
  bits = (bits & 0x000FFFFFFFFFFFFFULL) + 0x3FE6A09E667F3BCDULL;
  const double m = FromBits(bits);
  const double s = (m - 1.0) / (m + 1.0);
  const double z = s * s;
  double series = 1.0 / 21.0;
  series = series * z + 1.0 / 19.0;
  series = series * z + 1.0 / 17.0;
  series = series * z + 1.0 / 15.0;
  series = series * z + 1.0 / 13.0;
  series = series * z + 1.0 / 11.0;
  series = series * z + 1.0 / 9.0;
  series = series * z + 1.0 / 7.0;
  series = series * z + 1.0 / 5.0;
  series = series * z + 1.0 / 3.0;
  series = series * z + 1.0;
  return -2.0 * (exponent * 0.69314718055994530942 + 2.0 * s * series);
}

/// sin(2 pi t) and cos(2 pi t) for t = word / 2^32: reduced to an eighth of a turn around the nearest quarter, then
/// Taylor series to below 1e-16.
void SinCosTurn(std::uint32_t word, double& sine, double& cosine)
{
  const std::uint32_t quarter = (word + 0x20000000U) >> 30;
  const std::int32_t rest = static_cast<std::int32_t>(word - (quarter << 30));
  const double x = static_cast<double>(rest) * (6.28318530717958647693 / 4294967296.0);
  const double z = x * x;
  double s = -1.0 / 1307674368000.0;
  s = s * z + 1.0 / 6227020800.0;
  s = s * z - 1.0 / 39916800.0;
  s = s * z + 1.0 / 362880.0;
  s = s * z - 1.0 / 5040.0;
  s = s * z + 1.0 / 120.0;
  s = s * z - 1.0 / 6.0;
  s = s * z * x + x;
  double c = 1.0 / 20922789888000.0;
  c = c * z - 1.0 / 87178291200.0;
  c = c * z + 1.0 / 479001600.0;
  c = c * z - 1.0 / 3628800.0;
  c = c * z + 1.0 / 40320.0;
  c = c * z - 1.0 / 720.0;
  c = c * z + 1.0 / 24.0;
  c = c * z - 0.5;
  c = c * z + 1.0;
  const bool swap = (quarter & 1U) != 0;
  const double first = swap ? c : s;
  const double second = swap ? s : c;
  sine = (quarter & 2U) != 0 ? -first : first;
  cosine = ((quarter + 1U) & 2U) != 0 ? -second : second;
}

/// The method of [Box1958] with u = (radius + 1/2) / 2^32 on Count pairs of words.
void BoxMuller(const std::uint32_t* radius, const std::uint32_t* angle, double* first, double* second)
{
  for (int k = 0; k < Count; ++k)
  {
    const double u = (static_cast<double>(radius[k]) + 0.5) * (1.0 / 4294967296.0);
    const double r = __builtin_sqrt(MinusTwoLog(u));
    double sine;
    double cosine;
    SinCosTurn(angle[k], sine, cosine);
    first[k] = r * cosine;
    second[k] = r * sine;
  }
}
} // namespace

void SURFSYNTH_FILL_BLOCKS(const NormalKey& key, std::uint32_t firstBlock, double* out)
{
  std::uint32_t words[4][Count];
  const philox4x32_key_t philoxKey = { { static_cast<std::uint32_t>(key.Seed),
    static_cast<std::uint32_t>(key.Seed >> 32) } };
  for (int k = 0; k < Count; ++k)
  {
    const philox4x32_ctr_t counter = { { firstBlock + static_cast<std::uint32_t>(k), key.Component, key.Sample,
      key.Stream } };
    const philox4x32_ctr_t random = philox4x32_R(10, counter, philoxKey);
    for (int word = 0; word < 4; ++word)
    {
      words[word][k] = random.v[word];
    }
  }
  double normals[4][Count];
  BoxMuller(words[0], words[1], normals[0], normals[1]);
  BoxMuller(words[2], words[3], normals[2], normals[3]);
  for (int k = 0; k < Count; ++k)
  {
    for (int point = 0; point < 4; ++point)
    {
      out[4 * k + point] = normals[point][k];
    }
  }
}

} // namespace surfsynth
