// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/HeaderParser.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <iterator>
#include <limits>

namespace surfsynth
{

namespace
{
/// Iterator over the text that counts the bytes read: the events of the parser have no position.
class CountingIterator
{
public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::uint64_t* consumed)
    : At(at)
    , Consumed(consumed)
  {}
  const char& operator*() const { return *this->At; }
  CountingIterator& operator++()
  {
    ++this->At;
    ++*this->Consumed;
    return *this;
  }
  CountingIterator operator++(int)
  {
    const CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return this->At == other.At; }
  bool operator!=(const CountingIterator& other) const { return this->At != other.At; }

private:
  const char* At;
  std::uint64_t* Consumed;
};

/// Receives the events of nlohmann's SAX interface, whose names its functions have.
class HeaderEvents
{
public:
  explicit HeaderEvents(const std::string& file)
    : File(file)
  {}

  SafetensorsHeader Header;
  std::uint64_t Consumed = 0;

  bool null() { return this->Unexpected("null"); }
  bool boolean(bool) { return this->Unexpected("a boolean"); }
  bool binary(nlohmann::json::binary_t&) { return this->Unexpected("binary data"); }
  bool number_integer(std::int64_t value) { return this->NotAnInteger(std::to_string(value)); }
  bool number_float(double, const std::string& text) { return this->NotAnInteger(text); }
  bool number_unsigned(std::uint64_t value)
  {
    if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    {
      return this->NotAnInteger(std::to_string(value));
    }
    if (this->Where == Place::Shape)
    {
      if (this->Entry.Shape.size() == MaximumRank)
      {
        this->Fail(SafetensorsRule::Names, this->Tensor() + " has more than 8 dimensions", "a rank of at most 8");
      }
      this->Entry.Shape.push_back(static_cast<std::int64_t>(value));
    }
    else if (this->Where == Place::Offsets && this->OffsetsRead < 2)
    {
      (this->OffsetsRead++ == 0 ? this->Entry.Begin : this->Entry.End) = static_cast<std::int64_t>(value);
    }
    else
    {
      return this->Unexpected("a number");
    }
    return true;
  }
  bool string(std::string& value)
  {
    if (this->Where == Place::Metadata)
    {
      this->Header.Metadata[this->MetadataKey] = value;
    }
    else if (this->Where == Place::Type)
    {
      if (!TypeFromName(value, this->Entry.Type))
      {
        this->Fail(SafetensorsRule::Types, this->Tensor() + " has the unsupported dtype \"" + value + "\"",
          "F64, F32, F16, BF16, I64, I32, I16, I8, U8 or BOOL");
      }
      this->Where = Place::Entry;
    }
    else
    {
      return this->Unexpected("a string");
    }
    return true;
  }
  bool start_object(std::size_t)
  {
    switch (this->Where)
    {
      case Place::Outside:
        this->Where = Place::Root;
        return true;
      case Place::MetadataStart:
        this->Where = Place::Metadata;
        return true;
      case Place::EntryStart:
        this->Where = Place::Entry;
        this->Entry = TensorEntry();
        this->SeenType = this->SeenShape = this->SeenOffsets = false;
        this->OffsetsRead = 0;
        return true;
      default:
        return this->Unexpected("an object");
    }
  }
  bool key(std::string& name)
  {
    switch (this->Where)
    {
      case Place::Root:
        this->RootKey(name);
        return true;
      case Place::Metadata:
        if (this->Header.Metadata.count(name) != 0)
        {
          this->Repeated(name);
        }
        this->MetadataKey = name;
        return true;
      default: // Place::Entry: keys occur in objects only
        this->EntryKey(name);
        return true;
    }
  }
  bool end_object()
  {
    if (this->Where == Place::Entry)
    {
      if (!this->SeenType || !this->SeenShape || !this->SeenOffsets)
      {
        this->Fail(SafetensorsRule::HeaderStructure, this->Tensor() + " lacks dtype, shape or data_offsets",
          "exactly these three");
      }
      this->Header.Tensors.emplace(this->Name, std::move(this->Entry));
    }
    this->Where = this->Where == Place::Root ? Place::Outside : Place::Root;
    return true;
  }
  bool start_array(std::size_t)
  {
    if (this->Where == Place::ShapeStart)
    {
      this->Where = Place::Shape;
      return true;
    }
    if (this->Where == Place::OffsetsStart)
    {
      this->Where = Place::Offsets;
      return true;
    }
    return this->Unexpected("an array");
  }
  bool end_array()
  {
    if (this->Where == Place::Offsets && this->OffsetsRead != 2)
    {
      this->Fail(SafetensorsRule::HeaderStructure, this->Tensor() + " has one data offset or none", "two");
    }
    this->Where = Place::Entry;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& error)
  {
    const bool inIntegers = this->Where == Place::Shape || this->Where == Place::Offsets;
    this->Consumed = position;
    this->Fail(inIntegers ? SafetensorsRule::Integers : SafetensorsRule::HeaderStructure,
      "not JSON (" + std::string(error.what()) + ")", inIntegers ? "plain decimal integers" : "strict JSON");
  }

private:
  /// Place of the next event in the header.
  enum class Place
  {
    Outside,
    Root,
    MetadataStart,
    Metadata,
    EntryStart,
    Entry,
    Type,
    ShapeStart,
    Shape,
    OffsetsStart,
    Offsets
  };

  [[noreturn]] void Fail(SafetensorsRule rule, const std::string& found, const std::string& expected) const
  {
    ThrowFormatError(this->File, HeaderStart + this->Consumed, rule, found, expected);
  }
  [[noreturn]] void Repeated(const std::string& key) const
  {
    this->Fail(SafetensorsRule::HeaderStructure, "the key \"" + key + "\" occurs twice", "different keys");
  }
  std::string Tensor() const { return "tensor \"" + this->Name + "\""; }

  bool Unexpected(const std::string& what) const
  {
    switch (this->Where)
    {
      case Place::Shape:
      case Place::Offsets:
        this->Fail(this->OffsetsRead == 2 ? SafetensorsRule::HeaderStructure : SafetensorsRule::Integers,
          this->Tensor() + " has " + what + " in its shape or offsets", "integers, two of them in data_offsets");
      case Place::Metadata:
      case Place::MetadataStart:
        this->Fail(SafetensorsRule::HeaderStructure, "__metadata__ holds " + what, "strings only");
      default:
        this->Fail(SafetensorsRule::HeaderStructure, what + " stands where it may not",
          "an object of tensors, each of dtype, shape and data_offsets");
    }
  }
  bool NotAnInteger(const std::string& text) const
  {
    if (this->Where == Place::Shape || this->Where == Place::Offsets)
    {
      this->Fail(SafetensorsRule::Integers, this->Tensor() + " has the number " + text,
        "digits without sign, fraction, exponent or leading zero, at most 2^63 - 1");
    }
    return this->Unexpected("a number");
  }

  void RootKey(const std::string& name)
  {
    if (name == "__metadata__")
    {
      if (this->SeenMetadata)
      {
        this->Repeated(name);
      }
      this->SeenMetadata = true;
      this->Where = Place::MetadataStart;
      return;
    }
    if (const std::string defect = NameDefect(name); !defect.empty())
    {
      this->Fail(SafetensorsRule::Names, defect, "1 to 1024 bytes without control characters");
    }
    if (this->Header.Tensors.count(name) != 0)
    {
      this->Repeated(name);
    }
    if (this->Header.Tensors.size() == MaximumNumberOfTensors)
    {
      this->Fail(SafetensorsRule::Names, "there are more than 100000 tensors", "at most as many");
    }
    this->Name = name;
    this->Where = Place::EntryStart;
  }
  void EntryKey(const std::string& name)
  {
    bool* seen = nullptr;
    if (name == "dtype")
    {
      seen = &this->SeenType;
      this->Where = Place::Type;
    }
    else if (name == "shape")
    {
      seen = &this->SeenShape;
      this->Where = Place::ShapeStart;
    }
    else if (name == "data_offsets")
    {
      seen = &this->SeenOffsets;
      this->Where = Place::OffsetsStart;
    }
    else
    {
      this->Fail(SafetensorsRule::HeaderStructure, this->Tensor() + " has the key \"" + name + "\"",
        "dtype, shape and data_offsets only");
    }
    if (*seen)
    {
      this->Repeated(name);
    }
    *seen = true;
  }

  const std::string& File;
  Place Where = Place::Outside;
  std::string Name;
  std::string MetadataKey;
  TensorEntry Entry;
  bool SeenMetadata = false;
  bool SeenType = false;
  bool SeenShape = false;
  bool SeenOffsets = false;
  int OffsetsRead = 0;
};
} // namespace

SafetensorsHeader HeaderParser::Parse(std::string_view text) const
{
  HeaderEvents events(this->File);
  const CountingIterator begin(text.data(), &events.Consumed);
  const CountingIterator end(text.data() + text.size(), &events.Consumed);
  nlohmann::json::sax_parse(begin, end, &events); // every failure throws
  return std::move(events.Header);
}

} // namespace surfsynth
