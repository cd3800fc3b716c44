// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/TextureSampling.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
/// The two texels of a linear interpolation along one axis, and the weight of the second one.
struct Linear
{
  std::int64_t First;
  std::int64_t Second;
  float Weight;
};

/// Texels around @p coordinate, which is finite, along an axis of @p size texels.
Linear Between(double coordinate, int size, TextureWrap wrap)
{
  const bool repeat = wrap == TextureWrap::Repeat;
  const double inside = repeat ? coordinate - std::floor(coordinate) : std::clamp(coordinate, 0.0, 1.0);
  const double position = inside * size - 0.5;
  const double below = std::floor(position);
  const auto first = static_cast<std::int64_t>(below);
  const auto place = [&](std::int64_t k) {
    return repeat ? (k + size) % size : std::clamp<std::int64_t>(k, 0, size - 1);
  };
  return { place(first), place(first + 1), static_cast<float>(position - below) };
}

void Sample(const TextureView& texture, const Linear& x, const Linear& y, float* out)
{
  const auto texel = [&](std::int64_t i, std::int64_t j) {
    return texture.Values + texture.Channels * (j * texture.Width + i);
  };
  const float* corners[4] = { texel(x.First, y.First), texel(x.Second, y.First), texel(x.First, y.Second),
    texel(x.Second, y.Second) };
  for (int c = 0; c < texture.Channels; ++c)
  {
    const float lower = corners[0][c] + x.Weight * (corners[1][c] - corners[0][c]);
    const float upper = corners[2][c] + x.Weight * (corners[3][c] - corners[2][c]);
    out[c] = lower + y.Weight * (upper - lower);
  }
}
} // namespace

void SampleTexture(const TextureView& texture, TextureWrap wrap, const TextureCoordinates& coordinates,
  const SurfacePlace* places, std::int64_t count, float* out)
{
  if (texture.Values == nullptr || texture.Width < 1 || texture.Height < 1 || texture.Channels < 1 ||
    texture.Channels > 4)
  {
    throw InvalidInput("SampleTexture: an image of " + std::to_string(texture.Width) + " x " +
      std::to_string(texture.Height) + " texels with " + std::to_string(texture.Channels) +
      " channels; expected at least one texel and 1 to 4 channels.");
  }
  const std::int64_t triangles = coordinates.rows() / 3;
  ParallelFor(count, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t q = begin; q < end; ++q)
    {
      const Index f = places[q].Triangle;
      if (f < -1 || f >= triangles)
      {
        throw InvalidInput("SampleTexture: place " + std::to_string(q) + " lies in triangle " + std::to_string(f) +
          "; expected an id in [0, " + std::to_string(triangles) + "), or -1 for no place.");
      }
      float* values = out + texture.Channels * q;
      if (f < 0)
      {
        std::fill_n(values, texture.Channels, 0.0F);
        continue;
      }
      const auto corners = coordinates.middleRows<3>(3 * std::int64_t(f));
      const Eigen::Vector3d& w = places[q].Weights;
      const Eigen::RowVector2d at = w[0] * corners.row(0) + w[1] * corners.row(1) + w[2] * corners.row(2);
      if (!at.allFinite())
      {
        throw InvalidInput("SampleTexture: the texture coordinates at place " + std::to_string(q) + " in triangle " +
          std::to_string(f) + " are not finite; expected finite ones.");
      }
      Sample(texture, Between(at.x(), texture.Width, wrap), Between(at.y(), texture.Height, wrap), values);
    }
  });
}

} // namespace surfsynth
