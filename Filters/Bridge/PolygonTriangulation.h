// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Triangulation of polygons. Private to the bridge.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolygon.h>

namespace surfsynth
{

/// Cuts polygons into triangles that keep the polygon's winding and use its vertices only. Holds scratch memory: one
/// object for each thread.
class PolygonTriangulator
{
public:
  /// Writes the @p count - 2 triangles of the polygon with the vertices @p ids[0 .. count) to @p triangles.
  ///
  /// Quadrilaterals are cut along the shorter of the diagonals that lie inside, larger polygons by vtkPolygon's ear
  /// cutting, in coordinates relative to their first point and extent, so that the result does not depend on scale or
  /// offset. A polygon with a NaN or infinite coordinate becomes a fan: the mesh check then names the point.
  ///
  /// @param points the mesh's points, [V, 3]
  /// @param ids vertices in order, each in [0, V) and different from the others
  /// @param count number of vertices, at least 3
  /// @param triangles receives 3 (count - 2) vertex ids
  /// @return false when the polygon has no area, crosses itself or has no ear: @p triangles is then not usable.
  bool Triangulate(const PointMatrix& points, const Index* ids, Index count, Index* triangles);

private:
  bool CutEars(const PointMatrix& points, const Index* ids, Index count, Index* triangles);

  vtkNew<vtkPolygon> Polygon;
  vtkNew<vtkIdList> Corners;
};

} // namespace surfsynth
