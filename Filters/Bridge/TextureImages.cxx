// SPDX-License-Identifier: BSD-3-Clause
#include "TextureImages.h"

#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>

namespace surfsynth
{

std::array<int, 2> TextureResolution(int width, int height)
{
  constexpr int minimum = 16;
  constexpr int maximum = 16384;
  return { std::clamp(width, minimum, maximum), std::clamp(height, minimum, maximum) };
}

AtlasRasterOptions RasterOptionsOf(const int resolution[2], int gutterWidth)
{
  AtlasRasterOptions options;
  options.Width = resolution[0];
  options.Height = resolution[1];
  options.GutterWidth = gutterWidth < 0 ? AtlasRasterOptions::WholeImage : gutterWidth;
  return options;
}

void AnnounceEmptyImage(vtkInformation* output)
{
  auto* image = vtkImageData::SafeDownCast(vtkDataObject::GetData(output));
  if (image && image->GetNumberOfPoints() == 0)
  {
    constexpr int none[6] = { 0, -1, 0, -1, 0, -1 };
    output->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), none, 6);
    output->Set(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), none, 6);
  }
}

} // namespace surfsynth
