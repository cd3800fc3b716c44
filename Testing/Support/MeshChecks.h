// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Defects and measures of triangle meshes, and a search for places on them without a search structure.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <string>
#include <vector>

namespace surfsynth::test
{

/// A sentence for each defect of a manifold that is wound alike, and closed when asked; empty when there is none.
std::string DefectsOf(const TriangleMesh& mesh, bool closed = true);

/// Volume enclosed by a closed mesh, negative when it is wound inwards; of an open one, of the cone to the origin.
double VolumeOf(const TriangleMesh& mesh);

/// Sum of the areas of the triangles.
double AreaOf(const TriangleMesh& mesh);

/// V - E + F, points that no triangle uses left out.
std::int64_t EulerCharacteristicOf(const TriangleMesh& mesh);

/// A PlaceFinder that compares each point with every triangle: O(points x triangles), in parallel.
std::vector<SurfacePlace> NearestPlaces(const TriangleMesh& mesh, const PointMatrix& points);

/// Largest distance of a row of @p points to @p mesh.
double LargestDistance(const PointMatrix& points, const TriangleMesh& mesh);

/// True when both have the same triangles in the same order, each with the same corner first or another one.
bool SameTriangles(const TriangleMatrix& a, const TriangleMatrix& b);

} // namespace surfsynth::test
