// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places of boxes side by side in a grid.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The arrangement of boxes.
struct GridLayoutOptions
{
  std::int64_t Columns = 0; ///< 0: such that the grid is near 16 : 10 and has few empty cells
  double Spacing = 0.1;     ///< gap between two boxes, as a fraction of the largest box; >= 0
  int Across = 0;           ///< axis along which columns follow each other: 0, 1, 2
  int Down = 1;             ///< axis against which rows follow each other, another one
  /// Boxes are moved onto the centers of their cells. False: by the distance of their cell from the first one only, so that
  /// differences of position stay.
  bool Center = true;
};

/// Computes the translation of each box that lays all of them out in a grid, row by row, in their order. Columns are as wide
/// as their widest box and rows as high as their highest, with a gap of options.Spacing times the largest side of all boxes
/// along the axis. With options.Center false, all columns are as wide as the widest box and all rows as high as the
/// highest. The first box stays.
/// @return [N] translations, world units; one for each of @p boxes.
/// @throws InvalidInput when a number is out of its range, the axes are the same, or a box is not finite.
std::vector<Eigen::Vector3d> LayOutInGrid(const std::vector<BoundingBox>& boxes, const GridLayoutOptions& options);

} // namespace surfsynth
