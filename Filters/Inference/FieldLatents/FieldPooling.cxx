// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldPooling.h"

#include <algorithm>
#include <complex>

namespace surfsynth
{

namespace
{
/// out row += factor times the row, complex. @param factor a complex number
void AddTurned(const float* row, std::complex<float> factor, std::int64_t channels, float* out)
{
  for (std::int64_t c = 0; c < channels; ++c)
  {
    out[c] += factor.real() * row[c] - factor.imag() * row[channels + c];
    out[channels + c] += factor.real() * row[channels + c] + factor.imag() * row[c];
  }
}
} // namespace

void PoolFieldRows(const TangentHierarchy& surface, const float* fine, std::int64_t channels, std::int64_t first,
  std::int64_t rows, float* out)
{
  const std::int64_t width = 2 * channels;
  std::fill(out, out + rows * width, 0.0F);
  for (std::int64_t row = 0; row < rows; ++row)
  {
    const auto k = static_cast<std::size_t>(first + row);
    const float share = 1.0F / static_cast<float>(surface.MemberStart[k + 1] - surface.MemberStart[k]);
    for (Index m = surface.MemberStart[k]; m < surface.MemberStart[k + 1]; ++m)
    {
      const Index v = surface.Members[static_cast<std::size_t>(m)];
      AddTurned(fine + width * v, share * surface.ToCenter[static_cast<std::size_t>(v)], channels, out + width * row);
    }
  }
}

void UnpoolFieldRows(const TangentHierarchy& surface, const float* coarse, std::int64_t channels, std::int64_t first,
  std::int64_t rows, float* out)
{
  const std::int64_t width = 2 * channels;
  std::fill(out, out + rows * width, 0.0F);
  for (std::int64_t row = 0; row < rows; ++row)
  {
    const auto k = static_cast<std::size_t>(first + row);
    AddTurned(coarse + width * surface.Clusters[k], std::conj(surface.ToCenter[k]), channels, out + width * row);
  }
}

} // namespace surfsynth
