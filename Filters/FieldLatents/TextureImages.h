// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture images on output ports. Private to the module.
#pragma once

#include "Core/Atlas/AtlasRaster.h"

#include <array>

class vtkInformation;

namespace surfsynth
{

/// Returns a width and a height of texture images, texels, clamped to 16 to 16384.
std::array<int, 2> TextureResolution(int width, int height);

/// Returns the options of an atlas of a Resolution and a GutterWidth, -1 for the whole image.
AtlasRasterOptions RasterOptionsOf(const int resolution[2], int gutterWidth);

/// Announces that there is no image where an empty surface gave none: a pipeline that waits for one updates again and
/// again.
/// @param output information of the output port of an image, after the update
void AnnounceEmptyImage(vtkInformation* output);

} // namespace surfsynth
