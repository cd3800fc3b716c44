// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field latents of the colors of a surface.
#pragma once

#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include "TextureColors.h"
#include "WeldedSurface.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Computes the colors of @p count places of the surface that is encoded, RGB from -1 to 1 into @p out [@p count, 3].
using ColorSource = std::function<void(const SurfacePlace* places, std::int64_t count, float* out)>;

/// Colors of the surface that is encoded itself. @p colors must outlive the result.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT ColorSource ColorsOn(const TextureColors& colors);
/// Colors of the nearest places of another triangulation of the shape. All must outlive the result.
/// @param encoded mesh of the surface that is encoded
/// @param source mesh of the surface of @p colors
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT ColorSource ColorsOfNearest(
  const TriangleMesh& encoded, const TriangleMesh& source, const TextureColors& colors);

/// Samples in a ring for codes that a diffusion learns from or keeps: 128, or those of the training where these are more.
/// Codes of few samples depend on where the samples happen to lie: those of the shipped model turn by 20 to 30 degrees
/// between 32 samples and 1,024. No network can know these turns.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT int DiffusionSamplesPerRing(const FieldLatentEncoder& encoder);

/// Returns the points that are vertices of triangles.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT std::vector<Index> VerticesOf(const WeldedSurface& welded);

/// Encodes the colors in the rings of @p vertices, tile by tile, so that memory does not grow with the samples.
/// @param samplesPerRing samples in a ring, 1 to 4096; 0 for the number of the training
/// @return codes of all points, 0 for those that are not among @p vertices.
/// @throws InvalidInput, Cancelled
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT FieldLatentCodes EncodeColors(const FieldLatentEncoder& encoder,
  const WeldedSurface& welded, const ColorSource& colors, const std::vector<Index>& vertices, int samplesPerRing,
  const Progress& progress);

} // namespace surfsynth
