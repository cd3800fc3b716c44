// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/SafetensorsFile.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr std::uint64_t LongestHeader = 100000000;

/// Size of a regular file; opening anything else might wait or never end.
std::uint64_t RegularFileSize(const std::string& path)
{
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!error && !std::filesystem::is_regular_file(status))
  {
    throw InvalidInput("SafetensorsFile: " + path + " is not a file; expected a safetensors file.");
  }
  const std::uintmax_t size = error ? 0 : std::filesystem::file_size(path, error);
  if (error)
  {
    throw InvalidInput(
      "SafetensorsFile: cannot read " + path + ": " + error.message() + "; expected a safetensors file.");
  }
  return size;
}
} // namespace

SafetensorsFile::SafetensorsFile(const std::string& path, const SafetensorsLimits& limits)
  : File(path)
{
  const std::uint64_t size = RegularFileSize(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
  {
    throw InvalidInput(
      "SafetensorsFile: cannot open " + path + ": " + std::strerror(errno) + "; expected a readable file.");
  }
  const auto read = [&](std::uint64_t offset, std::uint64_t count, void* to) {
    stream.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(stream.gcount()) != count)
    {
      ThrowFormatError(path, offset + static_cast<std::uint64_t>(stream.gcount()), SafetensorsRule::Layout,
        "the file ended while it was read", std::to_string(size) + " bytes");
    }
  };
  this->Load(read, size, limits);
}

SafetensorsFile::SafetensorsFile(
  const void* bytes, std::size_t size, const std::string& name, const SafetensorsLimits& limits)
  : File(name)
{
  const auto* from = static_cast<const unsigned char*>(bytes);
  const auto read = [from](std::uint64_t offset, std::uint64_t count, void* to) {
    if (count > 0)
    {
      std::memcpy(to, from + offset, static_cast<std::size_t>(count));
    }
  };
  this->Load(read, size, limits);
}

/// Loads the file through @p read, which copies a range of it; the ranges follow each other.
template <typename ReadBytes>
void SafetensorsFile::Load(const ReadBytes& read, std::uint64_t size, const SafetensorsLimits& limits)
{
  unsigned char length[HeaderStart] = {};
  read(0, std::min(size, HeaderStart), length);
  const std::uint64_t headerLength = DecodeHeaderLength(
    this->File, length, size, std::min(limits.HeaderBytes, LongestHeader));
  std::string text(static_cast<std::size_t>(headerLength), '\0');
  read(HeaderStart, headerLength, text.data());

  this->DataStart = HeaderStart + headerLength;
  const std::uint64_t dataSize = size - this->DataStart;
  this->Header = ParseHeader(this->File, text, dataSize);
  // Not filled with zeros first: models are large.
  this->Data.reset(new unsigned char[static_cast<std::size_t>(dataSize)]);
  read(this->DataStart, dataSize, this->Data.get());
  this->CheckBooleans();
}

void SafetensorsFile::CheckBooleans() const
{
  for (const auto& [name, entry] : this->Header.Tensors)
  {
    if (entry.Type != TensorType::Bool)
    {
      continue;
    }
    const unsigned char* begin = this->Data.get() + entry.Begin;
    const unsigned char* end = this->Data.get() + entry.End;
    const unsigned char* bad = std::find_if(begin, end, [](unsigned char byte) { return byte > 1; });
    if (bad != end)
    {
      ThrowFormatError(this->File, this->DataStart + static_cast<std::uint64_t>(bad - this->Data.get()),
        SafetensorsRule::Types, "the BOOL tensor \"" + name + "\" holds the byte " + std::to_string(*bad), "0 or 1");
    }
  }
}

const TensorEntry& SafetensorsFile::Entry(const std::string& tensor) const
{
  const auto found = this->Header.Tensors.find(tensor);
  if (found == this->Header.Tensors.end())
  {
    throw ModelMismatch(this->File + ": there is no tensor \"" + tensor + "\".");
  }
  return found->second;
}

const unsigned char* SafetensorsFile::Bytes(const std::string& tensor) const
{
  return this->Data.get() + this->Entry(tensor).Begin;
}

const TensorEntry& SafetensorsFile::FloatingPointEntry(const std::string& tensor) const
{
  const TensorEntry& entry = this->Entry(tensor);
  if (!IsFloatingPoint(entry.Type))
  {
    throw ModelMismatch(this->File + ": tensor \"" + tensor + "\" is of type " + std::string(TypeName(entry.Type)) +
      "; expected F64, F32, F16 or BF16.");
  }
  return entry;
}

std::uint64_t SafetensorsFile::FileOffset(const TensorEntry& entry, std::int64_t element) const
{
  return this->DataStart + static_cast<std::uint64_t>(entry.Begin) +
    static_cast<std::uint64_t>(element) * ElementSize(entry.Type);
}

std::vector<double> SafetensorsFile::Float64(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  const unsigned char* bytes = this->Bytes(tensor);
  std::vector<double> values(static_cast<std::size_t>(entry.NumberOfElements()));
  for (double& value : values)
  {
    value = DecodeFloat(entry.Type, bytes);
    bytes += ElementSize(entry.Type);
  }
  return values;
}

std::vector<float> SafetensorsFile::Float32(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  const unsigned char* bytes = this->Bytes(tensor);
  std::vector<float> values(static_cast<std::size_t>(entry.NumberOfElements()));
  for (std::size_t k = 0; k < values.size(); ++k, bytes += ElementSize(entry.Type))
  {
    const double value = DecodeFloat(entry.Type, bytes);
    // Conversions that overflow are undefined: compare first.
    if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
    {
      ThrowFormatError(this->File, this->FileOffset(entry, static_cast<std::int64_t>(k)), SafetensorsRule::Meaning,
        "tensor \"" + tensor + "\" holds a number that is too large for float32", "numbers below 3.4e38");
    }
    values[k] = static_cast<float>(value);
  }
  return values;
}

std::vector<std::int64_t> SafetensorsFile::Integers(const std::string& tensor) const
{
  const TensorEntry& entry = this->Entry(tensor);
  if (IsFloatingPoint(entry.Type))
  {
    throw ModelMismatch(this->File + ": tensor \"" + tensor + "\" is of type " + std::string(TypeName(entry.Type)) +
      "; expected I64, I32, I16, I8, U8 or BOOL.");
  }
  const unsigned char* bytes = this->Bytes(tensor);
  std::vector<std::int64_t> values(static_cast<std::size_t>(entry.NumberOfElements()));
  for (std::int64_t& value : values)
  {
    value = DecodeInteger(entry.Type, bytes);
    bytes += ElementSize(entry.Type);
  }
  return values;
}

void SafetensorsFile::RequireFinite(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  const unsigned char* bytes = this->Bytes(tensor);
  for (std::int64_t k = 0; k < entry.NumberOfElements(); ++k, bytes += ElementSize(entry.Type))
  {
    if (!std::isfinite(DecodeFloat(entry.Type, bytes)))
    {
      ThrowFormatError(this->File, this->FileOffset(entry, k), SafetensorsRule::Meaning,
        "element " + std::to_string(k) + " of tensor \"" + tensor + "\" is not finite", "finite weights");
    }
  }
}

} // namespace surfsynth
