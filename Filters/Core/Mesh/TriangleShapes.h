// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Lengths, areas and angles of the triangles with finite coordinates. Private to the core.
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

/// Box around the finite points that triangles use; both corners are zero without any.
BoundingBox FiniteBox(const TriangleMesh& mesh);

/// Lengths of all edges between finite points, world units; ids are the lower point of the edge.
Distribution EdgeLengths(const TriangleMesh& mesh, const MeshTopology& topology);

/// Shapes of the triangles with finite corners that are not degenerate.
struct TriangleShapes
{
  Distribution SmallestAngle;                            ///< degrees
  Distribution LargestAngle;                             ///< degrees
  Distribution AspectRatio;                              ///< see MeshStatistics::AspectRatio
  MeshFinding Needles{ MeshDefect::DegenerateTriangle }; ///< see MeshStatistics::NeedleTriangles
};

/// Measures the triangles of @p mesh.
/// @param ids [F], the id of each triangle in the distributions
TriangleShapes MeasureTriangles(const TriangleMesh& mesh, const std::vector<Index>& ids);

} // namespace surfsynth
