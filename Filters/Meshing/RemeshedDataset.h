// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Remeshing of VTK's surfaces with their arrays. Only where CGAL is on; private to the library.
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

/// Requirements of RemeshIsotropically(): manifold edges and points, consistent winding.
VTKSURFACESYNTHESISMESHING_EXPORT MeshRequirements RemeshingRequirements();

/// Calls RemeshIsotropically() with progress and immediate cancellation.
/// @param surface, options outlive a cancelled call
/// @throws the errors of RemeshIsotropically()
VTKSURFACESYNTHESISMESHING_EXPORT RemeshedSurface RemeshSurface(std::shared_ptr<const Surface> surface,
  std::shared_ptr<const RemeshingOptions> options, const Progress& progress = {});

/// Fills @p output with the new mesh, in the precision of @p input, and the arrays of @p input: point arrays are
/// interpolated, cell arrays come from the nearest cell, field data is kept.
/// @param surface @p input, converted
/// @param remeshed with the places that point arrays need, and the origins that cell arrays need
VTKSURFACESYNTHESISMESHING_EXPORT void FillRemeshed(
  vtkPolyData* input, const Surface& surface, const RemeshedSurface& remeshed, vtkPolyData* output);

} // namespace surfsynth
