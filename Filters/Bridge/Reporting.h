// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Errors and warnings of filters, in the words of the place where they are read.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <string>

class vtkAlgorithm;

namespace surfsynth
{

/// Reports one error of @p self: @p text, after @p where when that is not empty. In the ParaView plugin the text is
/// InWordsOfParaView().
VTKSURFACESYNTHESISBRIDGE_EXPORT void ReportError(
  vtkAlgorithm* self, const std::string& where, const std::string& text);

/// The same for a warning.
VTKSURFACESYNTHESISBRIDGE_EXPORT void ReportWarning(
  vtkAlgorithm* self, const std::string& where, const std::string& text);

/// Returns @p text with the labels of ParaView's menu and panel for the names of classes and properties: "Surface Repair
/// with Hole Filling All Holes" for "vtkSurfaceRepairFilter with HoleFilling ALL_HOLES". What is in double quotes or
/// part of a path is the user's own and stays.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string InWordsOfParaView(const std::string& text);

} // namespace surfsynth
