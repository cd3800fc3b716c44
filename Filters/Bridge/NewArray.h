// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Arrays for the results of filters.
#pragma once

#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <cstddef>
#include <memory>
#include <string>

namespace surfsynth
{

/// Makes an array of zeros. @throws std::bad_alloc when there is no memory for it, which VTK's own allocation need not.
template <typename Array>
vtkSmartPointer<Array> NewArray(const std::string& name, vtkIdType tuples, int components)
{
  using Value = typename Array::ValueType;
  std::unique_ptr<Value[]> values(new Value[static_cast<std::size_t>(tuples) * static_cast<std::size_t>(components)]());
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetArray(values.release(), tuples * components, 0, Array::VTK_DATA_ARRAY_DELETE);
  return array;
}

} // namespace surfsynth
