// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places of a surface that the texels and points of a decoded texture show.
#pragma once

#include "SurfaceBridge.h"
#include "WeldedSurface.h"

#include "Core/Atlas/AtlasRaster.h"
#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

/// Places, and those among them whose colors are needed.
struct DecodedPlaces
{
  std::vector<SurfacePlace> Places;   ///< on the source; without a triangle (-1) for those that show nothing
  std::vector<std::uint32_t> Decoded; ///< numbers of the places to decode, by triangle
};

/// Texture atlas of a target, whose colors are those of the nearest places of a source.
class AtlasPlaces
{
public:
  /// Finds all places. Progress within [0, 1]; cancellable.
  /// @param source surface with the codes
  /// @param target surface with the atlas; itself the source where @p isSource
  /// @param coordinates those of an atlas: see RequireAtlas()
  /// @throws InvalidInput, Cancelled
  AtlasPlaces(const WeldedSurface& source, const Surface& target, bool isSource, TextureCoordinates coordinates,
    const AtlasRasterOptions& options, const Progress& progress);

  /// True when the places are those for these arguments and the same source.
  bool Is(const Surface& target, bool isSource, const TextureCoordinates& coordinates,
    const AtlasRasterOptions& options) const;

  DecodedPlaces Texels; ///< [Height Width], in the order of AtlasRaster; Decoded leaves out gutters
  /// Gutter texels and the texels whose colors they have.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> Gutters;
  DecodedPlaces Points; ///< [V] of the target
  std::string Warning;  ///< text about overlaps; empty without one

  /// Bytes that a texel takes while it is found and held, beside its color.
  static constexpr double BytesOfTexel = 64.0;

private:
  AtlasRaster Rasterize(const AtlasRasterOptions& options, const Progress& progress) const;
  void FindGutters(const AtlasRaster& raster);
  void MoveToSource(const WeldedSurface& source, const Surface& target, const Progress& progress);

  TextureCoordinates Coordinates;
  AtlasRasterOptions Options;
  std::uint64_t TargetHash = 0;
  bool OnSource = true;
};

} // namespace surfsynth
