// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/FormatNumber.h"

#include <cstdio>

namespace surfsynth
{

std::string FormatNumber(double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

} // namespace surfsynth
