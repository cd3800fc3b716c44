// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Lists of generator levels as users write them.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <string>
#include <vector>

namespace surfsynth
{

/// The numbers of @p text, which are at least 0 and stand between blanks and commas: "0 2, 3".
/// @param property whose value the text is, for messages. @throws InvalidInput naming what is no such number.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<int> ReadLevelList(const std::string& text, const std::string& property);

} // namespace surfsynth
