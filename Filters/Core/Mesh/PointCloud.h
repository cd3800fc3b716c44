// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Points in the form of nanoflann's dataset adaptors.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstddef>

namespace surfsynth
{

/// Adapter of the rows of a matrix, which must outlive it. The names are nanoflann's.
struct PointCloud
{
  const PointMatrix& Points;

  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(this->Points.rows()); }
  double kdtree_get_pt(std::size_t point, std::size_t axis) const
  {
    return this->Points(static_cast<Eigen::Index>(point), static_cast<Eigen::Index>(axis));
  }
  /// Returns false: nanoflann then computes the bounding box.
  template <typename Box>
  bool kdtree_get_bbox(Box&) const
  {
    return false;
  }
};

} // namespace surfsynth
