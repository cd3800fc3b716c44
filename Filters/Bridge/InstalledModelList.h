// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Installed models as VTK's arrays, for lists in user interfaces.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkNew.h>
#include <vtkStringArray.h>

#include <string>

namespace surfsynth
{

/// Names and folder of the installed models that suit a filter; valid until the next call of the same function.
class VTKSURFACESYNTHESISBRIDGE_EXPORT InstalledModelList
{
public:
  /// Names of the models of @p architecture whose metadata of that key contain @p text; read anew in each call.
  vtkStringArray* Names(const std::string& architecture, const std::string& text = "");
  /// Folder of the models; "" without one.
  const char* Folder();

private:
  vtkNew<vtkStringArray> NameArray;
  std::string FolderName;
};

} // namespace surfsynth
