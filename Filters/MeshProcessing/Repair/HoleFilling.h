// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Filling of holes [Liepa2003] and removal of flat triangles in a halfedge mesh. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <cstdint>

namespace surfsynth
{

/// Result of FillHoles().
struct FilledHoles
{
  std::int64_t Closed = 0;   ///< number of boundaries that were closed
  std::int64_t LeftOpen = 0; ///< number of boundaries that were left open
};

/// Closes the boundaries whose bounding box has a diagonal of at most @p largest, by triangles of the size of the
/// neighbours that continue their curvature [Liepa2003]; @p isFilling marks them. With a finite @p largest the outline
/// of a piece of surface, which lies within the bounding box of that boundary, is no hole.
/// @param largest world units, larger than 0; may be infinite
/// @param stop ends the work between two boundaries; may be null
/// @throws Cancelled
FilledHoles FillHoles(
  CgalMesh& mesh, double largest, CgalMesh::Property_map<CgalFace, bool>& isFilling, const std::atomic<bool>* stop);

/// Counts the triangles that are degenerate for the mesh check, or nearly so.
std::int64_t CountFlatTriangles(const CgalMesh& mesh);

/// Removes the triangles that are degenerate for the mesh check but not exactly flat: edges that are short for their
/// triangle are collapsed, and the longest edges of the others flipped, or the triangles removed on a boundary. Gives
/// up after a number of rounds.
void RemoveFlatTriangles(CgalMesh& mesh);

} // namespace surfsynth
