// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Arrays that filters on random fields add.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <cstdint>
#include <string>
#include <vector>

class vtkDoubleArray;
class vtkPolyData;

namespace surfsynth
{

/// Makes an uninitialised array. @throws std::bad_alloc, which vtkDoubleArray's own allocation need not.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkDoubleArray> NewNoiseArray(
  const std::string& name, vtkIdType tuples, int components);

/// Name of a sample's array: @p name, or name_sample where there are several samples.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string SampleName(
  const std::string& name, int numberOfSamples, std::uint32_t sample);

/// Adds the arrays to the points of @p output; the first becomes the active scalars where there are none.
/// @param active the first becomes the active scalars where there are others, too
VTKSURFACESYNTHESISBRIDGE_EXPORT void AddNoiseArrays(
  const std::vector<vtkSmartPointer<vtkDoubleArray>>& arrays, vtkPolyData* output, bool active = false);

} // namespace surfsynth
