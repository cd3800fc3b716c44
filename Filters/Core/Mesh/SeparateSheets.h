// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of the boundary of a solid, as volume meshing leaves it, to a manifold without defects of CheckMesh().
///
/// The functions take meshes with balanced edges: as many triangles run along an edge in one direction as in the other.
/// This is what closed and consistently wound means when more than two triangles may share an edge. Their results are
/// balanced too.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

namespace surfsynth
{

/// Removes degenerate triangles (MeshDefect::DegenerateTriangle) without opening holes. Two corners that are close for
/// the size of their triangle become one point; the edge opposite to a corner that lies on it is flipped. Pairs of
/// triangles on the same points that face opposite ways (a sheet without thickness) are removed too. Points that no
/// triangle uses any more are left out, and the others keep their order.
///
/// @param mesh balanced, with finite points; triangles may use a point twice.
/// @throws InvalidInput when the edges are not balanced, or an id is out of range.
TriangleMesh RemoveDegenerateTriangles(const TriangleMesh& mesh);

/// Makes a balanced mesh manifold without moving a point.
///
///  - Sheets that meet in an edge are taken apart so that each bounds its own part of the solid: the triangles around
///    the edge are sorted by angle, and the one through which a turn enters the solid is joined with the one through
///    which it leaves it.
///  - A point where several fans of triangles meet becomes one point for each fan; the first keeps the id, the others
///    follow behind the points of @p mesh.
///  - An edge that two sheets still share, because a single fan at either end passes along it twice, gets a point in
///    its middle for all sheets but the first.
///
/// The result is closed, consistently wound, and manifold in edges and points, as CheckMesh() sees it; triangles that
/// use a point twice, and pairs on the same points that face opposite ways, are left out. Serial but for the sorting:
/// about a quarter of a second for a million triangles.
///
/// @param mesh balanced, with finite points.
/// @throws InvalidInput when the edges are not balanced, or an id is out of range.
TriangleMesh SeparateSheets(const TriangleMesh& mesh);

} // namespace surfsynth
