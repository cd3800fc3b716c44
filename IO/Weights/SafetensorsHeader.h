// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// JSON header of a safetensors file. Private to the model files.
#pragma once

#include "IO/Weights/TensorType.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace surfsynth
{

/// One tensor of a file.
struct TensorEntry
{
  TensorType Type = TensorType::Float32; ///< type of the elements
  std::vector<std::int64_t> Shape;       ///< empty for a single number
  std::int64_t Begin = 0;                ///< first byte, counted from the end of the header
  std::int64_t End = 0;                  ///< end of the bytes, counted likewise

  /// Product of the dimensions: 0 when one of them is.
  std::int64_t NumberOfElements() const;
};

/// Formats the shape of a tensor for messages: "[2, 3]".
std::string FormatShape(const std::vector<std::int64_t>& shape);

/// Rules of the format, numbered as in messages.
enum class SafetensorsRule
{
  HeaderLength = 1, ///< 8 bytes, little-endian: at least 2, at most the limit, and within the file
  HeaderText = 2,   ///< UTF-8 without byte order mark, begins with {, only spaces after the closing }
  HeaderStructure =
    3,          ///< strict JSON, depth 3, no key twice, tensors of dtype, shape and data_offsets, string metadata
  Integers = 4, ///< digits only, no leading zero, at most 2^63 - 1
  Names = 5,    ///< 1 to 1024 bytes without control characters; at most 100,000 tensors, rank at most 8
  Types = 6,    ///< F64 F32 F16 BF16 I64 I32 I16 I8 U8 BOOL; BOOL bytes are 0 or 1
  Layout = 7,   ///< offsets contiguous from 0, byte counts as the shapes say, the last end is the end of the file
  Meaning = 9   ///< architecture, version and weights that can be used: finite numbers
};

/// Throws FormatError: "<file>: byte <offset>: <found>; expected <expected> (safetensors rule <n>)."
[[noreturn]] void ThrowFormatError(const std::string& file, std::uint64_t offset, SafetensorsRule rule,
  const std::string& found, const std::string& expected);

/// Content of a header.
struct SafetensorsHeader
{
  std::map<std::string, TensorEntry> Tensors;  ///< by name
  std::map<std::string, std::string> Metadata; ///< by key
};

/// Number of bytes before the header's text: they hold its length.
constexpr std::uint64_t HeaderStart = 8;

/// Decodes the length in the first 8 bytes and checks it against rule 1; allocates nothing. The message says so when they
/// begin a pickle or a ZIP archive, as checkpoints of PyTorch do.
/// @param file for messages.
/// @param fileSize bytes of the whole file.
/// @param largest limit of the length, see SafetensorsLimits::HeaderBytes.
/// @throws FormatError
std::uint64_t DecodeHeaderLength(
  const std::string& file, const unsigned char* bytes, std::uint64_t fileSize, std::uint64_t largest);

/// Parses the header's text and checks rules 2 to 7 (but for the bytes of BOOL tensors).
/// @param file for messages.
/// @param dataSize bytes of the file after the header.
/// @throws FormatError
SafetensorsHeader ParseHeader(const std::string& file, std::string_view text, std::uint64_t dataSize);

/// Sets @p bytes to the size of a tensor of that type and shape; returns false when it exceeds 2^63 - 1.
bool CountBytes(TensorType type, const std::vector<std::int64_t>& shape, std::int64_t& bytes);

/// Describes the defect of a tensor's name (rule 5); "" for a valid name.
std::string NameDefect(const std::string& name);

/// True for well-formed UTF-8: shortest forms, no surrogates, at most U+10FFFF. Else @p bad becomes the place of the
/// first byte that is not.
bool IsUtf8(std::string_view text, std::size_t& bad);

/// Maximum number of dimensions of a tensor (rule 5).
constexpr std::size_t MaximumRank = 8;
/// Maximum number of tensors of a file (rule 5).
constexpr std::size_t MaximumNumberOfTensors = 100000;

} // namespace surfsynth
