// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces that are too broken for ToSurface(): as much of them as can be used.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "SurfaceBridge.h"

#include <cstdint>

class vtkPolyData;

namespace surfsynth
{

/// The triangles of a polydata that name three different points which exist and are finite, and what was left out.
struct LooseSurface
{
  Surface Sound; ///< all points of the input, NaN and infinite ones set to zero; no triangle uses those

  std::int64_t CellsOutOfRange = 0;   ///< cells left out: they name a point that does not exist, or have no sound list
  std::int64_t CellsTooSmall = 0;     ///< polygons and strips left out: fewer than three different points
  std::int64_t NonFinitePoints = 0;   ///< points with a NaN or an infinite coordinate
  std::int64_t CellsNotFinite = 0;    ///< polygons and strips left out, in whole or in part: they use such a point
  std::int64_t PolygonsNotSimple = 0; ///< polygons without area or with a crossing outline, cut into a fan
  std::int64_t RepeatedPoints = 0;    ///< polygons that used a point twice, used without the repetition
};

/// Converts what can be converted of @p input; never fails on cells or coordinates.
/// @throws InvalidInput when there are more points or triangles than 2^31 - 1, or points do not have three coordinates.
VTKSURFACESYNTHESISBRIDGE_EXPORT LooseSurface ConvertLoosely(vtkPolyData* input);

} // namespace surfsynth
