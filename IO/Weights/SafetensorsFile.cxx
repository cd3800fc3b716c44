// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/SafetensorsFile.h"

#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

namespace surfsynth
{

namespace
{
constexpr std::uint64_t LongestHeader = 100000000;
/// Bytes of a tensor that are read at once, a multiple of the size of every type.
constexpr std::uint64_t PieceBytes = std::uint64_t(1) << 20;

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
  const auto stream = std::make_shared<std::ifstream>(path, std::ios::binary);
  if (!*stream)
  {
    throw InvalidInput(
      "SafetensorsFile: cannot open " + path + ": " + std::strerror(errno) + "; expected a readable file.");
  }
  this->ReadRange = [path, size, stream](std::uint64_t offset, std::uint64_t count, void* to) {
    stream->clear();
    stream->seekg(static_cast<std::streamoff>(offset));
    stream->read(static_cast<char*>(to), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(stream->gcount()) != count)
    {
      ThrowFormatError(path, offset + static_cast<std::uint64_t>(stream->gcount()), SafetensorsRule::Layout,
        "the file ended while it was read", std::to_string(size) + " bytes");
    }
  };
  this->ReadHeader(size, limits);
}

SafetensorsFile::SafetensorsFile(
  const void* bytes, std::size_t size, const std::string& name, const SafetensorsLimits& limits)
  : File(name)
{
  const auto* from = static_cast<const unsigned char*>(bytes);
  this->ReadRange = [from](std::uint64_t offset, std::uint64_t count, void* to) {
    std::copy_n(from + offset, count, static_cast<unsigned char*>(to));
  };
  this->ReadHeader(size, limits);
  // The caller's bytes may be gone when the tensors are read.
  const auto copy = std::make_shared<const std::vector<unsigned char>>(from, from + size);
  this->ReadRange = [copy](std::uint64_t offset, std::uint64_t count, void* to) {
    std::copy_n(copy->data() + offset, count, static_cast<unsigned char*>(to));
  };
}

void SafetensorsFile::ReadHeader(std::uint64_t size, const SafetensorsLimits& limits)
{
  unsigned char length[HeaderStart] = {};
  this->ReadRange(0, std::min(size, HeaderStart), length);
  const std::uint64_t headerLength = DecodeHeaderLength(
    this->File, length, size, std::min(limits.HeaderBytes, LongestHeader));
  std::string text(static_cast<std::size_t>(headerLength), '\0');
  this->ReadRange(HeaderStart, headerLength, text.data());
  this->DataStart = HeaderStart + headerLength;
  this->Header = ParseHeader(this->File, text, size - this->DataStart);
}

/// Reads the bytes of a tensor in pieces, and calls visit(element, bytes) for each of its elements in turn.
template <typename Visit>
void SafetensorsFile::ForEachElement(const TensorEntry& entry, const Visit& visit) const
{
  const auto size = static_cast<std::uint64_t>(ElementSize(entry.Type));
  const auto count = static_cast<std::uint64_t>(entry.NumberOfElements());
  std::vector<unsigned char> piece(static_cast<std::size_t>(std::min(count * size, PieceBytes)));
  for (std::uint64_t first = 0; first < count; first += PieceBytes / size)
  {
    const std::uint64_t elements = std::min(PieceBytes / size, count - first);
    this->ReadRange(this->FileOffset(entry, static_cast<std::int64_t>(first)), elements * size, piece.data());
    for (std::uint64_t k = 0; k < elements; ++k)
    {
      visit(static_cast<std::int64_t>(first + k), piece.data() + k * size);
    }
  }
}

std::uint64_t SafetensorsFile::DataBytes() const
{
  std::int64_t end = 0;
  for (const auto& entry : this->Header.Tensors)
  {
    end = std::max(end, entry.second.End);
  }
  return static_cast<std::uint64_t>(end);
}

void SafetensorsFile::RequireBoolean(
  const std::string& tensor, const TensorEntry& entry, std::int64_t element, unsigned char byte) const
{
  if (entry.Type == TensorType::Bool && byte > 1)
  {
    ThrowFormatError(this->File, this->FileOffset(entry, element), SafetensorsRule::Types,
      "the BOOL tensor \"" + tensor + "\" holds the byte " + std::to_string(byte), "0 or 1");
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

std::vector<unsigned char> SafetensorsFile::Bytes(const std::string& tensor) const
{
  const TensorEntry& entry = this->Entry(tensor);
  std::vector<unsigned char> bytes(static_cast<std::size_t>(entry.End - entry.Begin));
  this->ReadRange(this->FileOffset(entry, 0), bytes.size(), bytes.data());
  for (std::size_t k = 0; entry.Type == TensorType::Bool && k < bytes.size(); ++k)
  {
    this->RequireBoolean(tensor, entry, static_cast<std::int64_t>(k), bytes[k]);
  }
  return bytes;
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

void SafetensorsFile::RequireFloatingPoint(const std::string& tensor) const { this->FloatingPointEntry(tensor); }

void SafetensorsFile::RequireIntegers(const std::string& tensor) const
{
  const TensorEntry& entry = this->Entry(tensor);
  if (IsFloatingPoint(entry.Type))
  {
    throw ModelMismatch(this->File + ": tensor \"" + tensor + "\" is of type " + std::string(TypeName(entry.Type)) +
      "; expected I64, I32, I16, I8, U8 or BOOL.");
  }
}

void SafetensorsFile::RequireMemory(double copies) const
{
  const double needed = copies * static_cast<double>(this->DataBytes());
  const auto available = static_cast<double>(AvailableMemory());
  if (needed > available)
  {
    const auto gigabytes = [](double bytes) { return FormatNumber(std::ceil(bytes / 1e8) / 10.0) + " GB"; };
    throw InvalidInput("SafetensorsFile: reading " + this->File + " takes about " + gigabytes(needed) +
      " of memory; expected at most the " + gigabytes(available) + " that are available.");
  }
}

std::uint64_t SafetensorsFile::FileOffset(const TensorEntry& entry, std::int64_t element) const
{
  return this->DataStart + static_cast<std::uint64_t>(entry.Begin) +
    static_cast<std::uint64_t>(element) * ElementSize(entry.Type);
}

std::vector<double> SafetensorsFile::Float64(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  std::vector<double> values(static_cast<std::size_t>(entry.NumberOfElements()));
  this->ForEachElement(entry, [&](std::int64_t k, const unsigned char* bytes) {
    values[static_cast<std::size_t>(k)] = DecodeFloat(entry.Type, bytes);
  });
  return values;
}

std::vector<float> SafetensorsFile::Float32(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  std::vector<float> values(static_cast<std::size_t>(entry.NumberOfElements()));
  this->ForEachElement(entry, [&](std::int64_t k, const unsigned char* bytes) {
    const double value = DecodeFloat(entry.Type, bytes);
    // Conversions that overflow are undefined: compare first.
    if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
    {
      ThrowFormatError(this->File, this->FileOffset(entry, k), SafetensorsRule::Meaning,
        "tensor \"" + tensor + "\" holds a number that is too large for float32", "numbers below 3.4e38");
    }
    values[static_cast<std::size_t>(k)] = static_cast<float>(value);
  });
  return values;
}

std::vector<std::int64_t> SafetensorsFile::Integers(const std::string& tensor) const
{
  this->RequireIntegers(tensor);
  const TensorEntry& entry = this->Entry(tensor);
  std::vector<std::int64_t> values(static_cast<std::size_t>(entry.NumberOfElements()));
  this->ForEachElement(entry, [&](std::int64_t k, const unsigned char* bytes) {
    this->RequireBoolean(tensor, entry, k, *bytes);
    values[static_cast<std::size_t>(k)] = DecodeInteger(entry.Type, bytes);
  });
  return values;
}

void SafetensorsFile::RequireFinite(const std::string& tensor) const
{
  const TensorEntry& entry = this->FloatingPointEntry(tensor);
  this->ForEachElement(entry, [&](std::int64_t k, const unsigned char* bytes) {
    if (!std::isfinite(DecodeFloat(entry.Type, bytes)))
    {
      ThrowFormatError(this->File, this->FileOffset(entry, k), SafetensorsRule::Meaning,
        "element " + std::to_string(k) + " of tensor \"" + tensor + "\" is not finite", "finite weights");
    }
  });
}

} // namespace surfsynth
