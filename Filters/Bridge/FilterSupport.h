// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parts of VTK filters that do not depend on what they compute.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <string>

class vtkAlgorithm;
class vtkInformationVector;
class vtkObject;

namespace surfsynth
{

/// Sets a string property of @p self: calls Modified() only on change. Null stands for "".
VTKSURFACESYNTHESISBRIDGE_EXPORT void SetString(vtkObject* self, std::string& property, const char* text);

/// Returns true when the first input port of @p self has a data object, else reports an error that asks for surfaces:
/// for RequestDataObject.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool RequireSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector);

} // namespace surfsynth
