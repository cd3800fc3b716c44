// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Numbers in messages.
#pragma once

#include <string>

namespace surfsynth
{

/// @p value with six significant digits, in exponential form where that is shorter: 0.25, 1.6e-05, nan.
std::string Text(double value);

} // namespace surfsynth
