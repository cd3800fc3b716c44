// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The part of a distributed mesh that a rank assembles. Private to the library.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Distributed/MeshPiece.h"
#include "Distributed/RankGroup.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Cells of one rank that no lower rank holds, with the vertices that they, or other ranks, use.
struct MergedPiece
{
  TriangleMesh Mesh;                        ///< vertices and kept triangles
  std::vector<std::int64_t> CellOfTriangle; ///< [F], cell of the piece
  std::vector<std::int64_t> WholeIds;       ///< [U], id in the whole of each vertex
  std::vector<bool> Shared;                 ///< [U], true for vertices that several points are
  std::vector<Index> VertexOfPoint;         ///< [V], vertex of each point of the piece, -1 where no triangle uses it
  std::int64_t NumberOfWholePoints = 0;     ///< of all pieces together
};

/// Finds the points of the whole (see IdentifyPoints()) and leaves out cells that a lower rank holds, too. Collective.
/// @throws InvalidInput on all ranks when a triangle of one names a point that does not exist, or the arrays of a piece do
/// not fit its mesh.
MergedPiece MergePiece(const RankGroup& ranks, const MeshPiece& piece);

} // namespace surfsynth
