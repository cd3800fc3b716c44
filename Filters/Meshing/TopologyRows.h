// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The lines of a topology report. Private to the module.
#pragma once

#include "Core/Mesh/MeshStatistics.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

struct InspectedSurface;

struct ReportRow
{
  unsigned int Block = 0; ///< flat index, 0 for a surface by itself
  int Component = -1;     ///< -1 for the whole surface
  std::string Property;   ///< a name in CamelCase
  double Value = 0.0;
  std::int64_t First = -1; ///< id of the first cell or point that the value is about, -1 for none
  std::string Remark;
};

/// Everything about one surface. @p components is how many of its components get rows of their own, the largest first, in
/// a surface that has more than one.
std::vector<ReportRow> ReportRows(
  unsigned int block, const InspectedSurface& surface, const MeshStatistics& statistics, int components);

/// Whether ConvertSurface() and CheckSurface() would accept the surface for a filter without demands of its own.
bool IsValid(const InspectedSurface& surface, const MeshStatistics& statistics);

} // namespace surfsynth
