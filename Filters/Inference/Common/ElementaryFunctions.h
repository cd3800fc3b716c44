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

/// erfc(z), z = magnitude / sqrt 2 of a magnitude of at least 0, and bell = exp(-z^2): erfc(z) = t (a1 + ... + a5 t^4)
/// exp(-z^2), t = 1 / (1 + p z): [Abramowitz1964], formula 7.1.26, error below 1.5e-7.
SURFSYNTH_INLINE float Complement(float magnitude, float& bell)
{
  const float z = magnitude * 0.707106781F;
  const float t = 1.0F / (1.0F + 0.3275911F * z);
  float series = 1.061405429F;
  series = series * t - 1.453152027F;
  series = series * t + 1.421413741F;
  series = series * t - 0.284496736F;
  series = series * t + 0.254829592F;
  bell = Exp(-z * z);
  return series * t * bell;
}

/// x (1 + erf(x / sqrt 2)) / 2 [Hendrycks2016].
SURFSYNTH_INLINE float Gelu(float x)
{
  float bell;
  const float complement = Complement(Smaller(__builtin_fabsf(x), 13.0F), bell);
  return 0.5F * x * (x < 0.0F ? complement : 2.0F - complement);
}

/// log(1 + exp(x)) = max(x, 0) + log(1 + y) with y = exp(-|x|), and log(1 + y) = 2 artanh(y / (2 + y)) by its series to
/// s^15, s <= 1/3: accurate in relative terms also where it is tiny.
SURFSYNTH_INLINE float Softplus(float x)
{
  const float y = Exp(-__builtin_fabsf(x));
  const float s = y / (2.0F + y);
  const float z = s * s;
  float series = 1.0F / 15.0F;
  series = series * z + 1.0F / 13.0F;
  series = series * z + 1.0F / 11.0F;
  series = series * z + 1.0F / 9.0F;
  series = series * z + 1.0F / 7.0F;
  series = series * z + 1.0F / 5.0F;
  series = series * z + 1.0F / 3.0F;
  series = series * z + 1.0F;
  return Larger(x, 0.0F) + 2.0F * s * series;
}

SURFSYNTH_INLINE float Tanh(float x) { return 1.0F - 2.0F / (Exp(2.0F * x) + 1.0F); }

/// sin and cos of |x| < 1e5: minus the nearest multiple of pi / 2, in four parts so that products are exact, then
/// Taylor series to below 1e-8. Numbers without meaning for larger x; NaN for NaN.
SURFSYNTH_INLINE void SinCos(float x, float& sine, float& cosine)
{
  const float n = Nearest(x * 0.636619772F);
  float r = x - n * 1.5703125F;
  r -= n * 4.8351287841796875e-4F;
  r -= n * 3.13855707645416259766e-7F;
  r -= n * 6.0771005e-11F;
  const float z = r * r;
  float s = 1.0F / 362880.0F;
  s = s * z - 1.0F / 5040.0F;
  s = s * z + 1.0F / 120.0F;
  s = s * z - 1.0F / 6.0F;
  s = s * z * r + r;
  float c = 1.0F / 40320.0F;
  c = c * z - 1.0F / 720.0F;
  c = c * z + 1.0F / 24.0F;
  c = c * z - 0.5F;
  c = c * z + 1.0F;
  const std::int32_t quarter = static_cast<std::int32_t>(Larger(Smaller(n, 1e9F), -1e9F));
  const float first = (quarter & 1) != 0 ? c : s;
  const float second = (quarter & 1) != 0 ? s : c;
  sine = (quarter & 2) != 0 ? -first : first;
  cosine = ((quarter + 1) & 2) != 0 ? -second : second;
}

/// GELU(x) and its derivative Phi(x) + x phi(x), with Phi as in Gelu().
SURFSYNTH_INLINE void GeluAndDerivative(float x, float& value, float& derivative)
{
  const float magnitude = Smaller(__builtin_fabsf(x), 13.0F);
  float bell;
  const float complement = Complement(magnitude, bell);
  const float probability = 0.5F * (x < 0.0F ? complement : 2.0F - complement);
  value = x * probability;
  derivative = probability + 0.398942280F * (x < 0.0F ? -magnitude : magnitude) * bell;
}
} // namespace

} // namespace surfsynth
