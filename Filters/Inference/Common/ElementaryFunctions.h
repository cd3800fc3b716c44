// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Elementary functions of the kernels, for loops that compilers turn into vector code. Private to the inference;
/// included by sources that are compiled for one instruction set. Includes no standard header but <cstdint>: see
/// ActivationKernelsImplementation.h.
#pragma once

#include <cstdint>

#define SURFSYNTH_INLINE __attribute__((always_inline)) inline

namespace surfsynth
{

namespace
{
SURFSYNTH_INLINE float FromBits(std::int32_t bits)
{
  float value;
  __builtin_memcpy(&value, &bits, sizeof(value));
  return value;
}

SURFSYNTH_INLINE float Smaller(float a, float b) { return a < b ? a : b; }

SURFSYNTH_INLINE float Larger(float a, float b) { return a > b ? a : b; }

/// The nearest whole number of |x| < 2^22: adding 1.5 * 2^23 rounds away all binary places.
SURFSYNTH_INLINE float Nearest(float x)
{
  constexpr float shift = 12582912.0F;
  return (x + shift) - shift;
}

/// exp(x) = 2^n exp(r), |r| <= log(2) / 2, by Taylor's series to r^7. x is held within +-87, where float32 is normal.
SURFSYNTH_INLINE float Exp(float x)
{
  x = Smaller(Larger(x, -87.0F), 87.0F);
  const float n = Nearest(x * 1.44269504F);
  const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  float series = 1.0F / 5040.0F;
  series = series * r + 1.0F / 720.0F;
  series = series * r + 1.0F / 120.0F;
  series = series * r + 1.0F / 24.0F;
  series = series * r + 1.0F / 6.0F;
  series = series * r + 0.5F;
  series = series * r + 1.0F;
  series = series * r + 1.0F;
  return series * FromBits((static_cast<std::int32_t>(n) + 127) << 23);
}
} // namespace

} // namespace surfsynth
