// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Format of numbers in messages.
#pragma once

#include <string>

namespace surfsynth
{

/// Formats @p value with six significant digits, in exponential form where that is shorter: 0.25, 1.6e-05, nan.
std::string FormatNumber(double value);

} // namespace surfsynth
