// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Division and flattening of charts. Private to the mesh processing.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "MeshProcessing/Atlas/SurfaceCharts.h"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace surfsynth
{

/// Points of a flattened chart, [V, 2], in world units: with the area that the chart has on the surface.
using FlatPoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Divides a chart into parts of little curvature by variational shape approximation.
/// @param maximumParts largest number of parts, at least 2; fewer result when they approximate the chart well
/// @return [F], label of each triangle, at least two different ones; triangles of one label may be unconnected. F >= 2.
std::vector<std::size_t> DivideChart(const TriangleMesh& chart, std::size_t maximumParts);

/// Halves a chart at the median of its triangles' centers along the longest side of its box.
/// @return [F], 0 or 1 for each triangle, both as often; triangles of one label may be unconnected. F >= 2.
std::vector<std::size_t> HalveChart(const TriangleMesh& chart);

/// Flattens a disk by least squares conformal maps.
/// @return empty when this fails, flips a triangle or gives an outline that crosses itself.
FlatPoints FlattenConformally(const TriangleMesh& disk);

/// Projects a disk along its mean normal.
/// @return empty when this flips a triangle or gives an outline that crosses itself.
FlatPoints FlattenByProjection(const TriangleMesh& disk);

/// Stretch of a flattened chart; see SurfaceAtlas.
struct ChartStretch
{
  double Area = 0.0;           ///< square world units
  double SquaredStretch = 0.0; ///< area times mean of (S^2 + s^2) / 2
  double Largest = 1.0;        ///< largest of S and 1 / s
};
/// Measures the stretch of a chart without flipped triangles.
ChartStretch MeasureStretch(const TriangleMesh& chart, const FlatPoints& flat);

} // namespace surfsynth
