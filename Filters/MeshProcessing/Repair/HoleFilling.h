// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Closing holes and removing flat triangles of a halfedge mesh. Private to the meshing module.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <cstdint>

namespace surfsynth
{

/// What FillHoles() did with the boundaries of a mesh.
struct FilledHoles
{
  std::int64_t Closed = 0;
  std::int64_t LeftOpen = 0;
};

/// Closes the boundaries whose bounding box has a diagonal of at most @p largest, by triangles of the size of those
/// around that continue their curvature (Liepa, "Filling Holes in Meshes", 2003); @p isFilling marks them. With a finite
/// @p largest the outline of a piece of surface, which lies within the bounding box of that boundary, is no hole.
/// @throws Cancelled
FilledHoles FillHoles(
  CgalMesh& mesh, double largest, CgalMesh::Property_map<CgalFace, bool>& isFilling, const std::atomic<bool>* stop);

/// The number of triangles that the mesh check calls degenerate, or nearly so.
std::int64_t CountFlatTriangles(const CgalMesh& mesh);

/// Removes the triangles that the mesh check calls degenerate, and which are not exactly flat: edges that are short for
/// their triangle are collapsed, and the longest edges of the others flipped, or the triangles taken away on a boundary.
/// Gives up after a number of rounds.
void RemoveFlatTriangles(CgalMesh& mesh);

} // namespace surfsynth
