// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of a surface that may be broken in any way: unlike ConvertSurface() it does not throw because of a
/// defect, but counts what it left out.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// Number of cells with a fault, and the first of them.
struct CellFault
{
  std::int64_t Count = 0;
  std::int64_t First = -1; ///< id of the cell; -1 when there is none

  /// Counts @p cell; cells are to be added in ascending order.
  void Add(std::int64_t cell) { this->First = this->Count++ == 0 ? cell : this->First; }
};

/// Readable part of a surface, and the faults of the rest.
struct InspectedSurface
{
  /// All points (none when they have not three coordinates each), and the triangles of every polygon and strip that is
  /// not counted as a fault below. Ids are in range; triangles may still repeat a point, have no area, and so on.
  TriangleMesh Mesh;
  std::vector<std::int64_t> CellOfTriangle; ///< [F]
  std::int64_t Points = 0;                  ///< number of tuples of the coordinates
  int PointComponents = 3;                  ///< number of coordinates of each point

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

/// Reads @p input, which is not null, as far as it can be read. Points that are not finite and degenerate triangles are
/// taken over. @throws InvalidInput when there are more than 2^31 - 1 points.
VTKSURFACESYNTHESISBRIDGE_EXPORT InspectedSurface InspectSurface(vtkPolyData* input);

} // namespace surfsynth
