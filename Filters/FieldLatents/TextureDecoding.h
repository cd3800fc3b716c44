// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Colors of places from the field latents of a surface.
#pragma once

#include "AtlasPlaces.h"
#include "LatentArrays.h"
#include "WeldedSurface.h"

#include "Core/Common/Progress.h"
#include "Inference/FieldLatents/FieldLatentDecoder.h"

namespace surfsynth
{

/// Decodes places tile by tile, so that memory does not grow with their number.
/// @param out [number of places, 3], RGB; written for the places of DecodedPlaces::Decoded
/// @throws InvalidInput, Cancelled
void DecodeColors(const FieldLatentDecoder& decoder, const LatentField& field, const WeldedSurface& welded,
  const DecodedPlaces& places, unsigned char* out, const Progress& progress);

} // namespace surfsynth
