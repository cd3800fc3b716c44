// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Common parts of the readers and writers of dataset files. Private to the datasets.
#pragma once

#include <cstddef>
#include <string>

namespace surfsynth
{

class SafetensorsFile;

/// Version of the format of dataset files, in their metadata.
constexpr const char* DatasetFormatVersion = "1";

/// Memory for a file in units of its size: its numbers, and what is made of them.
constexpr double CopiesInMemory = 2.0;

/// Returns the value of a key of the metadata. @p expected: its value; "" for any. @p kind: end of the message, "as in
/// files of one surface at several scales".
/// @throws ModelMismatch when it is missing or another.
const std::string& RequireMetadata(
  const SafetensorsFile& file, const std::string& key, const std::string& expected, const std::string& kind);

/// Checks the numbers k of the tensors "<prefix>.<k>" and "<prefix>.<k>.<part>": 0 to @p count - 1, without leading zeros.
/// @throws ModelMismatch naming the first tensor with another number: after a gap it would not be read.
void RequireNumbers(const SafetensorsFile& file, const std::string& prefix, std::size_t count);

} // namespace surfsynth
