// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rows of a topology report. Private to the module.
#pragma once

#include "Core/Mesh/MeshStatistics.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace surfsynth
{

struct InspectedSurface;

/// A row of the table of vtkTopologyReport.
struct ReportRow
{
  unsigned int Block = 0; ///< flat index, 0 for a surface by itself
  int Component = -1;     ///< -1 for the whole surface
  std::string Property;   ///< a name in CamelCase
  double Value = 0.0;
  std::int64_t First = -1; ///< id of the first cell or point that the value refers to, -1 for none
  std::string Remark;
};

/// Ids of the triangles that intersect others, ascending; absent where the library is built without CGAL.
using IntersectingTriangles = std::optional<std::vector<Index>>;

/// Returns all rows of one surface.
/// @param components number of components with rows of their own, the largest first, in a surface of more than one
std::vector<ReportRow> ReportRows(unsigned int block, const InspectedSurface& surface, const MeshStatistics& statistics,
  const IntersectingTriangles& intersecting, int components);

/// Returns true when the remesher accepts the surface and no triangles intersect.
bool IsValid(
  const InspectedSurface& surface, const MeshStatistics& statistics, const IntersectingTriangles& intersecting);

} // namespace surfsynth
