// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Packing of charts into an image. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Atlas/ChartMaps.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Turns a flattened chart so that its box has the least area among turns by multiples of 3 degrees, stands upright and
/// has its lower corner at the origin.
void TurnToSmallestBox(FlatPoints& flat);

/// Places of boxes in an image.
struct BoxPacking
{
  double Scale = 0.0;                   ///< texels / unit of the boxes, the largest that fits
  std::vector<Eigen::Vector2d> Corners; ///< lower corner of each box, texels
};

/// Packs boxes into an image by its skyline: the highest first, each where it lies lowest, then leftmost. Boxes start at
/// whole texels, are @p margin texels apart and half of that from the sides.
/// @param sizes width and height of each box, larger than 0
/// @return Scale 0 when they do not fit at any scale.
BoxPacking PackBoxes(const std::vector<Eigen::Vector2d>& sizes, int width, int height, int margin);

} // namespace surfsynth
