// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Text.h"

#include <cstdio>

namespace surfsynth
{

std::string Text(double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

} // namespace surfsynth
