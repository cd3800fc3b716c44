// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Bilinear look-up of textures at places of a surface.
#pragma once

#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Mesh/SurfacePlace.h"

#include <cstdint>

namespace surfsynth
{

/// An image of the caller: rows from v = 0 upwards, as in VTK images, channels interleaved.
struct TextureView
{
  const float* Values = nullptr; ///< [Height, Width, Channels]
  int Width = 0;                 ///< texels along u, at least 1
  int Height = 0;                ///< texels along v, at least 1
  int Channels = 0;              ///< 1 to 4
};

/// Continuation of a texture outside [0, 1] x [0, 1].
enum class TextureWrap
{
  Clamp, ///< by its outermost texels
  Repeat ///< periodically
};

/// Looks up a texture at places of a surface, by bilinear interpolation between the centers of texels. Places without a
/// triangle (-1) give 0. Parallel; the same bits for every number of threads.
/// @param coordinates [3 F, 2]; outside [0, 1] as @p wrap says
/// @param places [@p count]
/// @param out [@p count, Channels]
/// @throws InvalidInput when the image is empty or has other than 1 to 4 channels, a triangle is out of range or a
/// coordinate is not finite.
void SampleTexture(const TextureView& texture, TextureWrap wrap, const TextureCoordinates& coordinates,
  const SurfacePlace* places, std::int64_t count, float* out);

} // namespace surfsynth
