// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Lists of generator levels as users write them.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <string>
#include <vector>

namespace surfsynth
{

/// Reads the numbers of @p text, which are at least 0 and stand between blanks and commas: "0 2, 3".
/// @param property name of the property with this text, for messages.
/// @throws InvalidInput naming the property and the first word that is no such number.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<int> ReadLevelList(const std::string& text, const std::string& property);

} // namespace surfsynth
