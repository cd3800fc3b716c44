// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parser of the JSON of a safetensors header. Private to the model files.
#pragma once

#include "IO/Weights/SafetensorsHeader.h"

#include <string>
#include <string_view>

namespace surfsynth
{

/// Parser that checks rules 3 to 6 of a header (see SafetensorsRule). Works event by event, without a document in
/// memory: it notices repeated keys, and a deep or large text costs nothing before it is refused.
class HeaderParser
{
public:
  /// @param file name of the file, for messages
  explicit HeaderParser(std::string file)
    : File(std::move(file))
  {}
  /// Parses the text of a header.
  /// @throws FormatError
  SafetensorsHeader Parse(std::string_view text) const;

private:
  std::string File;
};

} // namespace surfsynth
