// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Lengths, areas and angles of whatever triangles can be measured. Private to the core.
#pragma once

#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Areas of the triangles, [F] float64, square world units; 0 where a coordinate, or the area, is not finite.
Eigen::VectorXd FiniteAreas(const TriangleMesh& mesh);

/// The box around the finite points that triangles use.
BoundingBox FiniteBox(const TriangleMesh& mesh);

/// Lengths of all edges between finite points.
Distribution EdgeLengths(const TriangleMesh& mesh, const MeshTopology& topology);

/// Shapes of the triangles with finite corners that are not degenerate.
struct TriangleShapes
{
  Distribution SmallestAngle; ///< degrees
  Distribution LargestAngle;  ///< degrees
  Distribution AspectRatio;   ///< 1 for an equilateral triangle
};

/// @param ids the id of each triangle in the distributions
TriangleShapes MeasureTriangles(const TriangleMesh& mesh, const std::vector<Index>& ids);

} // namespace surfsynth
