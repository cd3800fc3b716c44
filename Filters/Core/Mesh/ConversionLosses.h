// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Counts of the cells and points that a conversion to triangles left out.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Numbers of cells and points that a conversion left out or changed; 0 where it lost nothing.
struct ConversionLosses
{
  std::int64_t CellsOutOfRange = 0;   ///< cells left out: a point id is out of range, or the list of ids is invalid
  std::int64_t CellsTooSmall = 0;     ///< polygons and strips left out: fewer than three different points
  std::int64_t NonFinitePoints = 0;   ///< points with a NaN or an infinite coordinate
  std::int64_t CellsNotFinite = 0;    ///< polygons and strips left out, in whole or in part: they use such a point
  std::int64_t PolygonsNotSimple = 0; ///< polygons without area or with a crossing outline, cut into a fan
  std::int64_t RepeatedPoints = 0;    ///< polygons that used a point twice, used without the repetition
};

} // namespace surfsynth
