// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Former name of FormatNumber(), for one release.
#pragma once

#include "Core/Common/FormatNumber.h"

namespace surfsynth
{

/// Former name of FormatNumber().
[[deprecated("use FormatNumber()")]] inline std::string Text(double value) { return FormatNumber(value); }

} // namespace surfsynth
