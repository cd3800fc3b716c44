// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Reads the JSON of a safetensors header event by event. Private to the model files.
#pragma once

#include "IO/Weights/SafetensorsHeader.h"

#include <string>
#include <string_view>

namespace surfsynth
{

/// Rules 3 to 6 of a header. Built on events and not on a document, so that repeated keys are seen and a deep or large
/// text costs nothing before it is refused.
class HeaderParser
{
public:
  explicit HeaderParser(std::string file)
    : File(std::move(file))
  {}
  /// @throws FormatError
  SafetensorsHeader Parse(std::string_view text) const;

private:
  std::string File;
};

} // namespace surfsynth
