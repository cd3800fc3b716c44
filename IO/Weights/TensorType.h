// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The element types of model files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace surfsynth
{

/// Element types that model files may hold.
enum class TensorType
{
  Float64,
  Float32,
  Float16,
  BFloat16,
  Int64,
  Int32,
  Int16,
  Int8,
  UInt8,
  Bool ///< one byte, 0 or 1
};

/// Size of an element in bytes.
std::size_t ElementSize(TensorType type);

/// Name of the type in safetensors headers: "F32".
std::string_view TypeName(TensorType type);

/// Sets @p type to the type with that name; false when there is none.
bool TypeFromName(std::string_view name, TensorType& type);

bool IsFloatingPoint(TensorType type);

/// The element that begins at @p bytes (any alignment, little-endian) of a floating-point type, exactly.
double DecodeFloat(TensorType type, const unsigned char* bytes);

/// The element that begins at @p bytes of an integer type or Bool, exactly.
std::int64_t DecodeInteger(TensorType type, const unsigned char* bytes);

} // namespace surfsynth
