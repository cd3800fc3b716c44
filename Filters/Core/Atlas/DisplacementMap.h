// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Displacement and height maps: the difference of a surface and its detailed version in a texture atlas.
#pragma once

#include "Core/Atlas/AtlasRaster.h"
#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Axes of the vectors of a displacement map.
enum class DisplacementSpace
{
  Object, ///< x, y and z of the points
  Tangent ///< tangent, normal and bitangent of SurfaceFrames
};

/// Options of BakeDisplacementMap().
struct DisplacementMapOptions
{
  AtlasRasterOptions Raster; ///< size and gutter of the images
  DisplacementSpace Space = DisplacementSpace::Object;
  /// Largest height, either side, at which the detailed surface is looked for, world units, at least 0; 0 for a tenth of
  /// the diagonal of the surface's box.
  double MaximumDistance = 0.0;
  bool ByIndex = true; ///< take places of equal index where the detailed surface is a subdivision
};

/// Images of the difference, rows from v = 0 upwards as in AtlasRaster, and what is known about them.
struct DisplacementMap
{
  std::vector<float> Displacements;    ///< [H, W, 3], world units; 0 where no triangle is
  std::vector<float> Heights;          ///< [H, W], world units; 0 where no triangle is
  std::vector<unsigned char> Coverage; ///< [H, W], 255 for texels whose centers lie in a triangle, else 0
  /// Number of subdivisions by which displacements go to places of equal index; -1 for those along normals.
  int SubdivisionLevels = -1;
  std::int64_t CoveredTexels = 0; ///< texels with coverage
  std::int64_t Misses = 0;        ///< those whose normal meets nothing, so that the closest place counts
  double MeanMiss = 0.0; ///< mean distance between the end of the height and the closest place, of Misses; world units
  double LargestMiss = 0.0;           ///< largest of these
  float LowestHeight = 0.0F;          ///< of the covered texels
  float HighestHeight = 0.0F;         ///< likewise
  std::vector<AtlasFinding> Findings; ///< degenerate, flipped and overlapping triangles of the atlas
};

/// Bakes the difference of a detailed surface and a plain one into images.
///
/// The height of a place is the way along its smooth normal (SurfaceFrames), either side, to the nearest triangle of the
/// detailed surface that faces along the normal; where there is none up to the MaximumDistance, the component along the
/// normal of the vector to the closest place. The displacement of a place goes to the same place on the detailed surface,
/// where that is a subdivision of the plain one at midpoints with any points (SubdivisionPlaces), and else to the place
/// whose height is baked: along the normal, or to the closest place.
///
/// Parallel over texels; the same bits for every number of threads. About 5 us for each texel of a triangle, and 60 bytes
/// for each texel of the image.
/// @param plain surface with the atlas, finite; need not be manifold
/// @param coordinates [3 F, 2], within [0, 1]
/// @param detailed finite, with at least one triangle; triangles may be degenerate
/// @throws InvalidInput as RasterizeAtlas() does; Cancelled
DisplacementMap BakeDisplacementMap(const TriangleMesh& plain, const TextureCoordinates& coordinates,
  const TriangleMesh& detailed, const DisplacementMapOptions& options, const Progress& progress = {});

} // namespace surfsynth
