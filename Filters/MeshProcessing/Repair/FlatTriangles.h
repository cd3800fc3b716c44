// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Removal of flat triangles from a halfedge mesh. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <cstdint>

namespace surfsynth
{

/// True when a triangle is degenerate for the mesh check, or nearly so.
bool IsFlatTriangle(const CgalMesh& mesh, CgalFace f);

/// Counts the triangles that are degenerate for the mesh check, or nearly so.
std::int64_t CountFlatTriangles(const CgalMesh& mesh);

/// Removes the triangles that are degenerate for the mesh check but not exactly flat: edges that are short for their
/// triangle are collapsed, and the longest edges of the others flipped, or the triangles removed on a boundary. Gives
/// up after a number of rounds.
void RemoveFlatTriangles(CgalMesh& mesh);

} // namespace surfsynth
