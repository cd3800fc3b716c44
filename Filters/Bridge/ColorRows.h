// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Colors of VTK arrays of any type, as the networks of field latents take them.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <string>
#include <vector>

class vtkDataArray;

namespace surfsynth
{

/// Colors of the tuples of an array.
struct ColorRows
{
  std::vector<float> Values;        ///< [N, 3], RGB from -1 (black) to 1
  std::vector<std::string> Remarks; ///< warnings: values that were clamped, alpha that was left out
};

/// Converts colors of 1 component (gray), 2 (gray and alpha), 3 (RGB) or 4 (RGBA). Integers range from 0 to the largest
/// number of their type, floating-point numbers from 0 to 1; values outside are clamped, alpha is left out. Parallel.
/// @param name begins messages: "The texture image"
/// @param isUsed for each tuple whether it is read; the others become black. Empty for all.
/// @throws InvalidInput when there are no tuples, other numbers of components, or a value is not finite.
VTKSURFACESYNTHESISBRIDGE_EXPORT ColorRows ReadColors(
  vtkDataArray* array, const std::string& name, const std::vector<bool>& isUsed = {});

} // namespace surfsynth
