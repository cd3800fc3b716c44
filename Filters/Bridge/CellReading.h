// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Access to the cells of a vtkCellArray that may be broken. Private to the bridge.
#pragma once

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>

#include <algorithm>
#include <cstdint>

namespace surfsynth
{

/// Number of cells; 0 for none, and for an array without offsets.
inline std::int64_t CountCells(vtkCellArray* cells)
{
  return cells ? std::max<std::int64_t>(cells->GetNumberOfCells(), 0) : 0;
}

/// Calls visit(cell, ids, size) for each cell of the storage, with null ids and size -1 where its offsets do not fit.
template <typename Id, typename Visit>
void EachCell(vtkAOSDataArrayTemplate<Id>* offsets, vtkAOSDataArrayTemplate<Id>* ids, const Visit& visit)
{
  const std::int64_t count = std::max<std::int64_t>(offsets->GetNumberOfValues() - 1, 0);
  const std::int64_t size = ids->GetNumberOfValues();
  const Id* first = size > 0 ? ids->GetPointer(0) : nullptr;
  for (std::int64_t cell = 0; cell < count; ++cell)
  {
    const std::int64_t begin = offsets->GetValue(cell);
    const std::int64_t end = offsets->GetValue(cell + 1);
    const bool fits = begin >= 0 && begin <= end && end <= size;
    visit(cell, fits ? first + begin : nullptr, fits ? end - begin : -1);
  }
}

/// The same for either type of id that the array stores.
template <typename Visit>
void EachCell(vtkCellArray* cells, const Visit& visit)
{
  if (CountCells(cells) == 0)
  {
    return;
  }
  if (cells->IsStorage64Bit())
  {
    EachCell(cells->GetOffsetsArray64(), cells->GetConnectivityArray64(), visit);
  }
  else
  {
    EachCell(cells->GetOffsetsArray32(), cells->GetConnectivityArray32(), visit);
  }
}

/// True when all ids are in [0, @p points).
template <typename Id>
bool InRange(const Id* ids, std::int64_t size, std::int64_t points)
{
  return std::all_of(ids, ids + size, [points](Id id) { return id >= 0 && static_cast<std::int64_t>(id) < points; });
}

} // namespace surfsynth
