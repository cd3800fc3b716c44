// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Packing of charts into an image. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Atlas/ChartMaps.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Turns a flattened chart so that its box has the least area, to a tenth of a degree, stands upright and has its lower
/// corner at the origin.
void TurnToSmallestBox(FlatPoints& flat);

/// A chart to pack.
struct ChartShape
{
  const FlatPoints* Points = nullptr;        ///< [V, 2], with the lower corner of their box at the origin
  const TriangleMatrix* Triangles = nullptr; ///< [F, 3]
};

/// Places of charts in an image.
struct ChartPacking
{
  double Scale = 0.0;                   ///< texels / unit of the charts; 0 when they fit at no scale
  std::vector<Eigen::Vector2d> Corners; ///< lower corner of the box of each chart, texels
  std::vector<bool> IsTurned;           ///< true for charts that are turned by 180 degrees
};

/// Packs charts into an image along its horizon, as [Levy2002] do: the highest first, each as low as its lower side lets
/// it sink onto the upper sides of those before, upright or upside down, leftmost among equal places. Charts keep
/// @p margin texels apart and half of that from the sides. The scale is the largest found by bisection, to a thousandth.
/// Images of more than 1,024 texels are divided into at most that many columns and rows of several texels.
ChartPacking PackCharts(const std::vector<ChartShape>& charts, int width, int height, int margin);

} // namespace surfsynth
