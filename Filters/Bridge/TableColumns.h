// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Columns of tables.
#pragma once

#include <vtkNew.h>
#include <vtkTable.h>

namespace surfsynth
{

/// Appends a column of class @p Array with that name, which holds @p values in their order.
template <typename Array, typename Values>
void AddColumn(vtkTable* table, const char* name, const Values& values)
{
  vtkNew<Array> column;
  column->SetName(name);
  for (const auto& value : values)
  {
    column->InsertNextValue(value);
  }
  table->AddColumn(column);
}

} // namespace surfsynth
