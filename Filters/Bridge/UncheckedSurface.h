// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of the usable part of a surface that is too broken for ToSurface().
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "SurfaceBridge.h"

#include "Core/Mesh/ConversionLosses.h"

class vtkPolyData;

namespace surfsynth
{

/// Triangles of a polydata that name three different points which exist and are finite, and counts of the rest.
struct UncheckedSurface
{
  Surface Usable;          ///< all points of the input, NaN and infinite ones set to zero; no triangle uses those
  ConversionLosses Losses; ///< what was left out or changed
};

/// Converts what can be converted of @p input; never fails on cells or coordinates.
/// @throws InvalidInput when there are more points or triangles than 2^31 - 1, or points do not have three coordinates.
VTKSURFACESYNTHESISBRIDGE_EXPORT UncheckedSurface ConvertUnchecked(vtkPolyData* input);

} // namespace surfsynth
