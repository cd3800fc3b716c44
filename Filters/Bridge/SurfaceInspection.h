// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The conversion of a surface that may be broken in any way: unlike ConvertSurface() it never throws because of the
/// surface, but tells what it had to leave out.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// How many cells have a fault, and the first of them.
struct CellFault
{
  std::int64_t Count = 0;
  std::int64_t First = -1;

  void Add(std::int64_t cell) { this->First = this->Count++ == 0 ? cell : this->First; }
};

/// What could be read of a surface.
struct InspectedSurface
{
  /// All points (none when they have not three coordinates each), and the triangles of every polygon and strip that is
  /// not counted as a fault below. Ids are in range; triangles may still repeat a point, have no area, and so on.
  TriangleMesh Mesh;
  std::vector<std::int64_t> CellOfTriangle; ///< [F]
  std::int64_t Points = 0;
  int PointComponents = 3;

  std::int64_t Vertices = 0; ///< cells
  std::int64_t Lines = 0;
  std::int64_t Triangles = 0;
  std::int64_t Quads = 0;
  std::int64_t Polygons = 0; ///< with five corners or more
  std::int64_t Strips = 0;

  CellFault Unreadable;    ///< offsets that do not fit the connectivity
  CellFault OutOfRange;    ///< polygons and strips that name a point that does not exist
  CellFault TooFewPoints;  ///< polygons and strips with fewer than three points
  CellFault RepeatedPoint; ///< polygons of four corners or more that use a point twice
  CellFault Uncut;         ///< polygons that cannot be cut into triangles
  CellFault IgnoredCells;  ///< vertices and lines with one of the first two faults; filters on surfaces ignore them
};

VTKSURFACESYNTHESISBRIDGE_EXPORT InspectedSurface InspectSurface(vtkPolyData* input);

} // namespace surfsynth
