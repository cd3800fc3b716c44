// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/TensorType.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace surfsynth
{

namespace
{
struct TypeDescription
{
  TensorType Type;
  std::string_view Name;
  std::size_t Size;
};

// In the order of TensorType.
constexpr std::array<TypeDescription, 10> Types = { {
  { TensorType::Float64, "F64", 8 },
  { TensorType::Float32, "F32", 4 },
  { TensorType::Float16, "F16", 2 },
  { TensorType::BFloat16, "BF16", 2 },
  { TensorType::Int64, "I64", 8 },
  { TensorType::Int32, "I32", 4 },
  { TensorType::Int16, "I16", 2 },
  { TensorType::Int8, "I8", 1 },
  { TensorType::UInt8, "U8", 1 },
  { TensorType::Bool, "BOOL", 1 },
} };

/// The bytes as an unsigned number, little-endian whatever the machine.
std::uint64_t LittleEndian(const unsigned char* bytes, std::size_t size)
{
  std::uint64_t value = 0;
  for (std::size_t k = size; k-- > 0;)
  {
    value = value << 8 | bytes[k];
  }
  return value;
}

template <typename Number, typename Bits>
Number FromBits(Bits bits)
{
  static_assert(sizeof(Number) == sizeof(Bits), "same size");
  Number number;
  std::memcpy(&number, &bits, sizeof(number));
  return number;
}

/// IEEE 754 binary16: 1 sign, 5 exponent and 10 fraction bits.
double DecodeHalf(std::uint64_t bits)
{
  const double sign = (bits & 0x8000U) != 0 ? -1.0 : 1.0;
  const int exponent = static_cast<int>(bits >> 10 & 0x1FU);
  const double fraction = static_cast<double>(bits & 0x3FFU);
  if (exponent == 31)
  {
    return fraction == 0.0 ? sign * std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  }
  // Subnormal numbers have the exponent of the smallest normal ones and no leading 1.
  return exponent == 0 ? sign * std::ldexp(fraction, -24) : sign * std::ldexp(1024.0 + fraction, exponent - 25);
}
} // namespace

std::size_t ElementSize(TensorType type) { return Types[static_cast<std::size_t>(type)].Size; }

std::string_view TypeName(TensorType type) { return Types[static_cast<std::size_t>(type)].Name; }

bool TypeFromName(std::string_view name, TensorType& type)
{
  for (const TypeDescription& description : Types)
  {
    if (description.Name == name)
    {
      type = description.Type;
      return true;
    }
  }
  return false;
}

bool IsFloatingPoint(TensorType type)
{
  return type == TensorType::Float64 || type == TensorType::Float32 || type == TensorType::Float16 ||
    type == TensorType::BFloat16;
}

double DecodeFloat(TensorType type, const unsigned char* bytes)
{
  const std::uint64_t bits = LittleEndian(bytes, ElementSize(type));
  switch (type)
  {
    case TensorType::Float64:
      return FromBits<double>(bits);
    case TensorType::Float32:
      return FromBits<float>(static_cast<std::uint32_t>(bits));
    case TensorType::Float16:
      return DecodeHalf(bits);
    default: // BFloat16: the upper half of a binary32
      return FromBits<float>(static_cast<std::uint32_t>(bits << 16));
  }
}

std::int64_t DecodeInteger(TensorType type, const unsigned char* bytes)
{
  const std::uint64_t bits = LittleEndian(bytes, ElementSize(type));
  switch (type)
  {
    case TensorType::Int64:
      return FromBits<std::int64_t>(bits);
    case TensorType::Int32:
      return FromBits<std::int32_t>(static_cast<std::uint32_t>(bits));
    case TensorType::Int16:
      return FromBits<std::int16_t>(static_cast<std::uint16_t>(bits));
    case TensorType::Int8:
      return FromBits<std::int8_t>(static_cast<std::uint8_t>(bits));
    default: // UInt8 and Bool
      return static_cast<std::int64_t>(bits);
  }
}

} // namespace surfsynth
