// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Arrays of a dataset that vary a random field from place to place. Private to the module.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Noise/MaternField.h"

#include <string>

class vtkDataSet;

namespace surfsynth
{

/// Names of the arrays, each empty for none.
struct FieldArrayNames
{
  std::string RangeFactor; ///< point array, 1 component, > 0
  std::string Direction;   ///< point array, 3 components
  std::string Boundary;    ///< point array, 1 component, not 0 for true
  std::string Barrier;     ///< cell array, 1 component, not 0 for true

  /// True when a name is given.
  bool Any() const;
};

/// Reads the arrays of @p dataset, whose triangles or tetrahedra are those of @p surface, as MaternField takes them.
/// @throws InvalidInput, naming array and property, when an array is not there, has another number of components or of
/// tuples, or a value out of range.
MaternFieldArrays ReadFieldArrays(vtkDataSet* dataset, const Surface& surface, const FieldArrayNames& names);

} // namespace surfsynth
