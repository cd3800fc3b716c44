// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Element types of model files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace surfsynth
{

/// Element types that model files may hold.
enum class TensorType
{
  Float64,  ///< F64: IEEE 754 binary64
  Float32,  ///< F32: IEEE 754 binary32
  Float16,  ///< F16: IEEE 754 binary16
  BFloat16, ///< BF16: the upper half of a binary32
  Int64,    ///< I64
  Int32,    ///< I32
  Int16,    ///< I16
  Int8,     ///< I8
  UInt8,    ///< U8
  Bool      ///< BOOL: one byte, 0 or 1
};

/// Size of an element in bytes.
std::size_t ElementSize(TensorType type);

/// Name of the type in safetensors headers: "F32".
std::string_view TypeName(TensorType type);

/// Sets @p type to the type with that name; false when there is none.
bool TypeFromName(std::string_view name, TensorType& type);

/// True for Float64, Float32, Float16 and BFloat16.
bool IsFloatingPoint(TensorType type);

/// Decodes the element of a floating-point type that begins at @p bytes (any alignment, little-endian), exactly.
double DecodeFloat(TensorType type, const unsigned char* bytes);

/// Decodes the element of an integer type or Bool that begins at @p bytes, exactly.
std::int64_t DecodeInteger(TensorType type, const unsigned char* bytes);

} // namespace surfsynth
