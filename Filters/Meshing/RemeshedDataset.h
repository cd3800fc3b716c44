// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Remeshing of VTK's surfaces with their arrays, for the filters that do so. Only where CGAL is on; private to the
/// library.
#pragma once

#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"
#include "SurfaceBridge.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"

#include <memory>

class vtkPolyData;

namespace surfsynth
{

/// What RemeshIsotropically() asks of a surface: manifold edges and points, consistent winding.
VTKSURFACESYNTHESISMESHING_EXPORT MeshRequirements RemeshingRequirements();

/// RemeshIsotropically() with progress, and cancelled at once.
/// @param surface, options outlive this call when it is cancelled.
/// @throws what RemeshIsotropically() throws
VTKSURFACESYNTHESISMESHING_EXPORT RemeshedSurface RemeshSurface(std::shared_ptr<const Surface> surface,
  std::shared_ptr<const RemeshingOptions> options, const Progress& progress = {});

/// Puts the new mesh, in the precision of @p input, and the arrays of @p input into @p output: point arrays are
/// interpolated, cell arrays come from the nearest cell, field data is kept.
/// @param surface @p input, converted
/// @param remeshed with the places that point arrays need, and the origins that cell arrays need
VTKSURFACESYNTHESISMESHING_EXPORT void FillRemeshed(
  vtkPolyData* input, const Surface& surface, const RemeshedSurface& remeshed, vtkPolyData* output);

} // namespace surfsynth
