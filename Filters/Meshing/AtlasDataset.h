// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture atlases of VTK's surfaces with their arrays. Only where CGAL is on; private to the libraries.
#pragma once

#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include "MeshProcessing/Atlas/SurfaceAtlas.h"
#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"

#include <memory>

class vtkPolyData;

namespace surfsynth
{

/// Calls MakeSurfaceAtlas() with progress and immediate cancellation. Points of equal coordinates count as one where the
/// surface then meets the requirements of an atlas, else all points count as they are.
/// @param surface of @p input, meets the requirements of an atlas; outlives a cancelled call
/// @throws the errors of MakeSurfaceAtlas()
VTKSURFACESYNTHESISMESHING_EXPORT SurfaceAtlas MakeAtlas(vtkPolyData* input,
  const std::shared_ptr<const Surface>& surface, const SurfaceAtlasOptions& options, const Progress& progress = {});

/// Fills @p output with the surface and its texture coordinates: see vtkTextureAtlasFilter.
/// @param surface @p input, converted
/// @param atlas of @p surface
VTKSURFACESYNTHESISMESHING_EXPORT void FillAtlas(
  vtkPolyData* input, const Surface& surface, const SurfaceAtlas& atlas, vtkPolyData* output);

} // namespace surfsynth
