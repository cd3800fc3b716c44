// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Gutters of texture atlases. Private to the core.
#pragma once

#include "Core/Atlas/AtlasRaster.h"

namespace surfsynth
{

/// Fills empty texels of @p raster with what the nearest texel that is not empty shows, by the Euclidean distance of
/// centers; parallel, with the same bits for every number of threads. The distance transform of [Meijster2000], with the
/// nearest texel beside each distance. O(Width Height).
/// @param width distance up to which texels are filled, in texels; AtlasRasterOptions::WholeImage for all
void FillGutter(AtlasRaster& raster, int width);

} // namespace surfsynth
