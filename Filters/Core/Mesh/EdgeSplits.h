// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Splits of some edges of a mesh: another triangulation of the same surface.
#pragma once

#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>

namespace surfsynth
{

/// Splits edges at their midpoints, and each triangle into as many as one and the number of its split edges. A triangle
/// with two of them is split along the shorter diagonal of what is left; the corner between them comes first. O(V + F) but
/// for the sorting of the edges around each vertex.
/// @param isSplit called once for each edge, by its number in EdgeGroups
/// @return the old vertices, then the midpoints by the number of their edges; triangles in the order of those that they
/// come from
/// @throws InvalidInput when an id is out of range, a triangle uses a vertex twice, or the result would have 2^31
/// vertices or triangles, or more.
SubdividedMesh SplitEdges(const TriangleMesh& mesh, const std::function<bool(std::int64_t edge)>& isSplit);

} // namespace surfsynth
