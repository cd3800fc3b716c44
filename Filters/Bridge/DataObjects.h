// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Properties of VTK's data objects, and new ones.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

using DataObjectList = std::vector<vtkSmartPointer<vtkDataObject>>;

/// Number of points and cells of @p data together; 0 for null.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::int64_t SizeOf(vtkDataObject* data);

/// True for null, and for what has neither points nor cells.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool IsEmpty(vtkDataObject* data);

/// A dataset by itself, or a leaf of a composite one.
struct Leaf
{
  vtkDataObject* Data = nullptr; ///< belongs to the input
  std::string Place;             ///< "" by itself, "Block 3" with the flat index of a leaf: begins messages
};

/// The leaves of a composite dataset in order, without null ones; or @p data itself; none of null.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<Leaf> LeavesOf(vtkDataObject* data);

/// Makes an empty object of the class with that name: "vtkPolyData".
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkDataObject> NewDataObject(const std::string& className);

/// Makes the first array of @p names that a dataset of @p data has, at its points or else at its cells, its active scalars;
/// those of the points are deselected where it is an array of cells, because viewers color by these first.
VTKSURFACESYNTHESISBRIDGE_EXPORT void SelectScalars(vtkDataObject* data, const std::vector<std::string>& names);

} // namespace surfsynth
