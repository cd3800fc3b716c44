// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// One rank's piece of a mesh that lies distributed over ranks.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// One rank's piece of a surface. Points on the seams lie on several ranks, with the same global ids or coordinates; a cell
/// that several ranks hold counts once.
struct MeshPiece
{
  TriangleMesh Mesh;                        ///< points and triangles, without ghost cells; may be empty
  std::vector<std::int64_t> CellOfTriangle; ///< [F], cells that triangles are parts of; empty when triangle f is cell f
  /// [V], ids in the whole surface; empty for none. Used where all pieces with points have them; else points with the same
  /// coordinates on several ranks are one.
  std::vector<std::int64_t> GlobalIds;
};

} // namespace surfsynth
