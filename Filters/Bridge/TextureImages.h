// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture images on output ports.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Atlas/AtlasRaster.h"

#include <array>

class vtkInformation;

namespace surfsynth
{

/// Returns a width and a height of texture images, texels, clamped to 16 to 16384.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::array<int, 2> TextureResolution(int width, int height);

/// Returns the options of an atlas of a Resolution and a GutterWidth, -1 for the whole image.
VTKSURFACESYNTHESISBRIDGE_EXPORT AtlasRasterOptions RasterOptionsOf(const int resolution[2], int gutterWidth);

/// Announces that there is no image where an empty surface gave none: a pipeline that waits for one updates again and
/// again.
/// @param output information of the output port of an image, after the update
VTKSURFACESYNTHESISBRIDGE_EXPORT void AnnounceEmptyImage(vtkInformation* output);

} // namespace surfsynth
