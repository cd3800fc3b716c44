// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture atlases of surfaces without texture coordinates.
#pragma once

#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Mesh/TriangleMesh.h"

#include <atomic>
#include <vector>

namespace surfsynth
{

/// Options of MakeSurfaceAtlas().
struct SurfaceAtlasOptions
{
  int Width = 1024;  ///< texels along u of the image that the atlas is packed for, 16 to 32768
  int Height = 1024; ///< texels along v, 16 to 32768
  /// Least distance of two charts, texels, 1 to 256; half of it is left at the sides of the image. Bilinear interpolation
  /// needs 3, each level of a mipmap twice as many.
  int Margin = 4;
  /// Largest stretch of a triangle, larger than 1: lengths on the surface are at most this many times, and at least this
  /// fraction of, those in the texture, relative to their mean over the chart. A smaller number makes more charts.
  double MaximumStretch = 2.0;
};

/// A texture atlas of a surface.
struct SurfaceAtlas
{
  TextureCoordinates Coordinates;     ///< [3 F, 2], within [0, 1]; no triangles overlap
  std::vector<Index> ChartOfTriangle; ///< [F], in order of the lowest triangle of each chart
  Index NumberOfCharts = 0;           ///< number of charts
  double TexelsPerLength = 0.0;       ///< mean texel density, texels / world unit, the same in all charts
  double Coverage = 0.0;              ///< part of the image that triangles cover, 0 to 1
  /// Root of the mean over the surface of (S^2 + s^2) / 2 [Sander2001]; 1 without distortion. S is the largest and s the
  /// smallest ratio, in a triangle, of a length on the surface to its length in the texture, relative to the mean density.
  double RootMeanStretch = 1.0;
  double LargestStretch = 1.0; ///< largest of all S and 1 / s
};

/// Makes a texture atlas.
///
/// Each connected part of the surface is divided into charts by variational shape approximation [CohenSteiner2004], by the
/// hierarchical seeding of CGAL's Variational_shape_approximation. A chart is flattened by least squares conformal maps
/// [Levy2002], or else projected along its mean normal. One that is no disk, that overlaps itself or that is stretched by
/// more than MaximumStretch is divided further; a single triangle is always flat. Charts get the same mean texel density,
/// are turned to their smallest rectangles and packed along the horizon of the image, the highest first [Levy2002].
///
/// Deterministic: the same surface and options give the same bits. Single-threaded.
/// @param mesh manifold, consistently wound; open or closed, any genus and number of components
/// @param stop when not null: ends the work once it is true; looked at before each division and flattening of a chart
/// @return empty coordinates for a mesh without triangles.
/// @throws InvalidInput when the mesh has a defect (see CheckMesh()), an option is out of range, or the charts do not fit
/// into the image with their margins.
/// @throws Cancelled when @p stop becomes true.
SurfaceAtlas MakeSurfaceAtlas(
  const TriangleMesh& mesh, const SurfaceAtlasOptions& options = {}, const std::atomic<bool>* stop = nullptr);

} // namespace surfsynth
