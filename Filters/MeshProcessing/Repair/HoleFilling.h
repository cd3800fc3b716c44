// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Filling of holes [Liepa2003] in a halfedge mesh. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <atomic>
#include <cstdint>

namespace surfsynth
{

/// Result of FillHoles().
struct FilledHoles
{
  std::int64_t Closed = 0;       ///< number of boundaries that were closed
  std::int64_t LeftOpen = 0;     ///< number of boundaries that were left open because of the limit
  std::int64_t FlatOutlines = 0; ///< number of outlines of flat pieces that were left open without a limit
  std::int64_t Unsuitable = 0;   ///< number of boundaries that were left open because no filling met the requirements
};

/// Requirements of the triangles that close a hole. Where the usual ones do not meet them, triangles that follow the
/// curvature less are tried: refined without fairing, then without points inside.
struct FillingRequirements
{
  bool NoFlatTriangles = false; ///< none is degenerate for the mesh check, or nearly so
  bool NoIntersections = false; ///< none intersects another triangle
};

/// Closes the boundaries whose bounding box has a diagonal of at most @p largest, by triangles of the size of the
/// neighbours that continue their curvature [Liepa2003]; @p isFilling marks them. The outline of a piece of surface,
/// which lies within the bounding box of that boundary, is no hole when @p largest is finite or the piece is flat.
/// @param largest world units, larger than 0; may be infinite
/// @param stop ends the work between two boundaries; may be null
/// @throws Cancelled
FilledHoles FillHoles(CgalMesh& mesh, double largest, CgalMesh::Property_map<CgalFace, bool>& isFilling,
  const std::atomic<bool>* stop, const FillingRequirements& requirements = {});

} // namespace surfsynth
