// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Colors of places from the field latents of a surface.
#pragma once

#include "AtlasPlaces.h"
#include "LatentArrays.h"
#include "WeldedSurface.h"

#include "Core/Common/Progress.h"
#include "Inference/FieldLatents/FieldLatentDecoder.h"

#include <vtkSmartPointer.h>

#include <string>

class vtkImageData;
class vtkPolyData;

namespace surfsynth
{

/// Decodes places tile by tile, so that memory does not grow with their number.
/// @param out [number of places, 3], RGB; written for the places of DecodedPlaces::Decoded
/// @throws InvalidInput, Cancelled
void DecodeColors(const FieldLatentDecoder& decoder, const LatentField& field, const WeldedSurface& welded,
  const DecodedPlaces& places, unsigned char* out, const Progress& progress);

/// Decodes the texture of an atlas, gutters included, and the colors of the points of @p output.
/// @param name of the point array that @p output gets, its active scalars, and of the scalars of the image
/// @param size width and height of the image, texels: those that @p atlas was made for
/// @return the image, unsigned char RGB
/// @throws InvalidInput, Cancelled
vtkSmartPointer<vtkImageData> DecodeTexture(const FieldLatentDecoder& decoder, const LatentField& field,
  const WeldedSurface& welded, const AtlasPlaces& atlas, const std::string& name, const int size[2],
  vtkPolyData* output, const Progress& progress);

} // namespace surfsynth
