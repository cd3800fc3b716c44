// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Safetensors files made by hand.
#pragma once

#include <cstdint>
#include <string>

namespace surfsynth::test
{

/// Makes a file of any header text and any data. The length is that of the text.
std::string FileOf(const std::string& header, const std::string& data = "");

/// Makes a file with any length of the header.
std::string FileWithLength(std::uint64_t length, const std::string& header, const std::string& data = "");

/// Header of one tensor: {"<name>":{"dtype":"<type>","shape":<shape>,"data_offsets":<offsets>}}
std::string OneTensor(
  const std::string& type, const std::string& shape, const std::string& offsets, const std::string& name = "w");

} // namespace surfsynth::test
