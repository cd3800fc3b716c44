// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Points of a mesh that lie at the same place.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// Finds the points of triangles at bit-equal coordinates, as seams of texture coordinates have them; 0 and -0 are equal.
/// @return [V], the lowest id among those at the place of each point; points that no triangle uses have their own.
std::vector<Index> WeldPoints(const TriangleMesh& mesh);

} // namespace surfsynth
