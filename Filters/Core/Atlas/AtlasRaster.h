// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rasterization of texture atlases: the place of the surface that each texel shows.
#pragma once

#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Options of RasterizeAtlas().
struct AtlasRasterOptions
{
  /// All texels of the image, as GutterWidth.
  static constexpr int WholeImage = -1;

  int Width = 1024;  ///< texels along u, 1 to 32768
  int Height = 1024; ///< texels along v, 1 to 32768
  /// Distance from the charts up to which empty texels are filled, in texels: 0 for the texels of bilinear interpolation
  /// only, 2^k for k further levels of a mipmap, or WholeImage.
  int GutterWidth = 8;
};

/// Kinds of texels of an atlas.
enum class TexelKind : std::uint8_t
{
  Empty,      ///< shows nothing
  Covered,    ///< its center lies in a triangle
  Overlapped, ///< its center lies inside several triangles; it shows the one with the lowest id
  Border,     ///< its center lies outside of all triangles, nearer than sqrt(2) texels to one
  Gutter      ///< filled from the nearest texel of another kind
};

/// The places that the texels of an atlas show, row by row: texel (i, j), i along u and j along v, has the number
/// j Width + i and its center at u = (i + 1/2) / Width, v = (j + 1/2) / Height.
struct AtlasRaster
{
  int Width = 0;                      ///< texels along u
  int Height = 0;                     ///< texels along v
  std::vector<SurfacePlace> Places;   ///< [Height Width], triangle (-1 for none) and barycentric coordinates
  std::vector<TexelKind> Kinds;       ///< [Height Width]
  std::vector<AtlasFinding> Findings; ///< degenerate, flipped and overlapping triangles
};

/// Finds the place of the surface that each texel of an atlas shows.
///
/// A texel whose center lies in a triangle shows its place there; at a common side the triangle with the lowest id has it.
/// A texel whose center lies outside of all triangles, but nearer than sqrt(2) texels to one, shows the nearest point of
/// the nearest triangle: these are all texels that a bilinear look-up inside a triangle can touch, so that triangles
/// thinner than a texel have texels too. The gutter beyond shows what the nearest of these texels shows (Euclidean distance
/// of centers).
///
/// An overlap is a texel whose center lies inside two triangles, by more than a thousandth of a texel each: common sides
/// and corners are none, and an overlap between the centers of texels is not seen.
///
/// Parallel over rows; the same bits for every number of threads. O(Width Height + F); 41 bytes for each texel.
/// @param coordinates [3 F, 2], within [0, 1]
/// @throws InvalidInput when a coordinate is not finite or outside [0, 1], naming the number and the first triangle, when
/// their number is no multiple of three, or when a size is out of range, more than 2^28 texels, or exceeds the memory.
AtlasRaster RasterizeAtlas(const TextureCoordinates& coordinates, const AtlasRasterOptions& options = {});

/// Counts the texels of the kinds Covered and Overlapped in the one-ring of each vertex.
/// @param triangles [F, 3], those that were rasterized
/// @return [numberOfPoints]; texels at which a texture can be told apart there.
/// @throws InvalidInput when the raster has a triangle that does not exist.
std::vector<std::int64_t> CountRingTexels(
  const AtlasRaster& raster, const TriangleMatrix& triangles, Index numberOfPoints);

} // namespace surfsynth
