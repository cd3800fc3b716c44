// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/SafetensorsHeader.h"

#include "IO/Weights/HeaderParser.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <limits>

namespace surfsynth
{

namespace
{
/// The text without the spaces after its closing brace, checked against rule 2.
std::string_view WithoutPadding(const std::string& file, std::string_view text)
{
  std::size_t bad = 0;
  if (!IsUtf8(text, bad))
  {
    ThrowFormatError(file, HeaderStart + bad, SafetensorsRule::HeaderText, "the header is not UTF-8", "UTF-8 text");
  }
  if (text.front() != '{')
  {
    ThrowFormatError(file, HeaderStart, SafetensorsRule::HeaderText, "the header does not begin with {",
      "a JSON object without a byte order mark");
  }
  const std::size_t last = text.find_last_not_of(' ');
  if (text[last] != '}')
  {
    ThrowFormatError(file, HeaderStart + last, SafetensorsRule::HeaderText, "the header does not end with }",
      "a JSON object, and only spaces after it");
  }
  return text.substr(0, last + 1);
}

/// Name of the kind of file that PyTorch writes and begins with these 8 bytes; null for others.
const char* PickleKind(const unsigned char* bytes)
{
  if (bytes[0] == 'P' && bytes[1] == 'K' && bytes[2] == 3 && bytes[3] == 4)
  {
    return "a ZIP archive";
  }
  return bytes[0] == 0x80 && bytes[1] >= 2 && bytes[1] <= 5 ? "a pickle" : nullptr;
}

/// Rule 7. The offsets are those of the data; messages give the end of the header as the place.
void CheckLayout(
  const std::string& file, const SafetensorsHeader& header, std::uint64_t dataStart, std::uint64_t dataSize)
{
  const auto fail = [&](std::int64_t offset, const std::string& found, const std::string& expected) {
    ThrowFormatError(file, dataStart + static_cast<std::uint64_t>(offset), SafetensorsRule::Layout, found, expected);
  };
  using Named = std::pair<const std::string, TensorEntry>;
  std::vector<const Named*> inOrder;
  for (const Named& tensor : header.Tensors)
  {
    inOrder.push_back(&tensor);
  }
  // Empty tensors lie before the tensor that begins where they end.
  std::sort(inOrder.begin(), inOrder.end(), [](const Named* a, const Named* b) {
    return std::make_pair(a->second.Begin, a->second.End) < std::make_pair(b->second.Begin, b->second.End);
  });
  std::int64_t end = 0;
  for (const Named* tensor : inOrder)
  {
    const TensorEntry& entry = tensor->second;
    const std::string name = "tensor \"" + tensor->first + "\"";
    std::int64_t bytes = 0;
    if (!CountBytes(entry.Type, entry.Shape, bytes))
    {
      fail(0, name + " of shape " + FormatShape(entry.Shape) + " exceeds 2^63 - 1 bytes", "a smaller tensor");
    }
    if (entry.Begin != end)
    {
      fail(0, name + " begins at offset " + std::to_string(entry.Begin),
        "offset " + std::to_string(end) + ": tensors without holes or overlap");
    }
    if (entry.End < entry.Begin || entry.End - entry.Begin != bytes)
    {
      fail(0, name + " has offsets [" + std::to_string(entry.Begin) + ", " + std::to_string(entry.End) + "]",
        std::to_string(bytes) + " bytes for " + std::string(TypeName(entry.Type)) + " " + FormatShape(entry.Shape));
    }
    end = entry.End;
  }
  if (static_cast<std::uint64_t>(end) != dataSize)
  {
    fail(0,
      "the header describes " + std::to_string(end) + " bytes of tensors and the file holds " +
        std::to_string(dataSize),
      "equal numbers");
  }
}
} // namespace

std::string FormatShape(const std::vector<std::int64_t>& shape)
{
  std::string text = "[";
  for (const std::int64_t extent : shape)
  {
    text += (text.size() > 1 ? ", " : "") + std::to_string(extent);
  }
  return text + "]";
}

void ThrowFormatError(const std::string& file, std::uint64_t offset, SafetensorsRule rule, const std::string& found,
  const std::string& expected)
{
  throw FormatError(file + ": byte " + std::to_string(offset) + ": " + found + "; expected " + expected +
    " (safetensors rule " + std::to_string(static_cast<int>(rule)) + ").");
}

std::int64_t TensorEntry::NumberOfElements() const
{
  // As many as the bytes say (rule 7): the product of dimensions may overflow before one of them is 0.
  return (this->End - this->Begin) / static_cast<std::int64_t>(ElementSize(this->Type));
}

std::uint64_t DecodeHeaderLength(
  const std::string& file, const unsigned char* bytes, std::uint64_t fileSize, std::uint64_t largest)
{
  const auto fail = [&file](const std::string& found, const std::string& expected) {
    ThrowFormatError(file, 0, SafetensorsRule::HeaderLength, found, expected);
  };
  if (fileSize < HeaderStart)
  {
    fail("the file has " + std::to_string(fileSize) + " bytes", "8 bytes that tell the length of the header");
  }
  std::uint64_t length = 0;
  for (int k = 7; k >= 0; --k)
  {
    length = length << 8 | bytes[k];
  }
  if (const char* kind = PickleKind(bytes); kind && (length > largest || length > fileSize - HeaderStart))
  {
    fail(std::string("the file is ") + kind + ", as PyTorch writes them; such files can run code and are never read",
      "a safetensors file, which \"python3 -m surfacesynthesis convert\" makes of the checkpoint of a PoissonNet");
  }
  const std::string found = "the length of the header is " + std::to_string(length);
  if (length < 2)
  {
    fail(found, "at least 2 bytes");
  }
  if (length > largest)
  {
    fail(found, "at most " + std::to_string(largest) + " bytes");
  }
  if (length > fileSize - HeaderStart)
  {
    fail(found, "at most the " + std::to_string(fileSize - HeaderStart) + " bytes that follow");
  }
  return length;
}

SafetensorsHeader ParseHeader(const std::string& file, std::string_view text, std::uint64_t dataSize)
{
  const std::string_view object = WithoutPadding(file, text);
  SafetensorsHeader header = HeaderParser(file).Parse(object);
  CheckLayout(file, header, HeaderStart + text.size(), dataSize);
  return header;
}

bool CountBytes(TensorType type, const std::vector<std::int64_t>& shape, std::int64_t& bytes)
{
  // A dimension of 0 makes a tensor empty, however large the others are.
  if (std::find(shape.begin(), shape.end(), 0) != shape.end())
  {
    bytes = 0;
    return true;
  }
  constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
  bytes = static_cast<std::int64_t>(ElementSize(type));
  for (const std::int64_t extent : shape)
  {
    if (bytes > largest / extent)
    {
      return false;
    }
    bytes *= extent;
  }
  return true;
}

std::string NameDefect(const std::string& name)
{
  if (name.empty())
  {
    return "a tensor has an empty name";
  }
  if (name.size() > 1024)
  {
    return "the name of a tensor has " + std::to_string(name.size()) + " bytes";
  }
  const auto isControl = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  return std::any_of(name.begin(), name.end(), isControl) ? "the name of a tensor holds a control character" : "";
}

bool IsUtf8(std::string_view text, std::size_t& bad)
{
  const auto byte = [&text](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  for (std::size_t k = 0; k < text.size();)
  {
    bad = k;
    const unsigned lead = byte(k);
    const std::size_t more = lead < 0x80 ? 0 : lead >= 0xC2 && lead < 0xE0 ? 1 : lead >> 4 == 0xE ? 2 : 3;
    if ((lead >= 0x80 && lead < 0xC2) || lead > 0xF4 || more >= text.size() - k)
    {
      return false;
    }
    std::uint32_t point = more == 0 ? lead : lead & (0x3FU >> more);
    for (std::size_t j = 1; j <= more; ++j)
    {
      if ((byte(k + j) & 0xC0U) != 0x80U)
      {
        return false;
      }
      point = point << 6 | (byte(k + j) & 0x3FU);
    }
    const bool overlong = (more == 2 && point < 0x800) || (more == 3 && point < 0x10000);
    if (overlong || (point >= 0xD800 && point <= 0xDFFF) || point > 0x10FFFF)
    {
      return false;
    }
    k += more + 1;
  }
  return true;
}

} // namespace surfsynth
