// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/SafetensorsWriter.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"
#include "IO/Weights/SafetensorsHeader.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace surfsynth
{

namespace
{
/// Puts @p text in quotes, with the escapes of JSON.
std::string Quoted(const std::string& text)
{
  std::size_t bad = 0;
  if (!IsUtf8(text, bad))
  {
    throw InvalidInput(
      "SerializeSafetensors: a name or text is not UTF-8 at byte " + std::to_string(bad) + "; expected UTF-8.");
  }
  return nlohmann::json(text).dump();
}

void CheckTensor(const std::string& name, const TensorData& tensor)
{
  const std::string prefix = "SerializeSafetensors: tensor \"" + name + "\"";
  if (const std::string defect = NameDefect(name); !defect.empty() || name == "__metadata__")
  {
    throw InvalidInput("SerializeSafetensors: " + (defect.empty() ? "a tensor is named __metadata__" : defect) +
      "; expected another name of 1 to 1024 bytes without control characters.");
  }
  std::int64_t bytes = 0;
  const bool negative = std::any_of(
    tensor.Shape.begin(), tensor.Shape.end(), [](std::int64_t extent) { return extent < 0; });
  if (tensor.Shape.size() > MaximumRank || negative || !CountBytes(tensor.Type, tensor.Shape, bytes))
  {
    throw InvalidInput(prefix + " has a shape that cannot be written; expected at most 8 dimensions of 0 or more.");
  }
  if (static_cast<std::size_t>(bytes) != tensor.Bytes.size())
  {
    throw InvalidInput(prefix + " has " + std::to_string(tensor.Bytes.size()) + " bytes; expected " +
      std::to_string(bytes) + " for its shape.");
  }
}

std::string EntryText(const TensorData& tensor, std::size_t begin)
{
  std::string text = "{\"dtype\":\"" + std::string(TypeName(tensor.Type)) + "\",\"shape\":[";
  for (std::size_t k = 0; k < tensor.Shape.size(); ++k)
  {
    text += (k > 0 ? "," : "") + std::to_string(tensor.Shape[k]);
  }
  return text + "],\"data_offsets\":[" + std::to_string(begin) + "," + std::to_string(begin + tensor.Bytes.size()) +
    "]}";
}

template <typename Number>
TensorData FromNumbers(TensorType type, std::vector<std::int64_t> shape, const std::vector<Number>& values)
{
  TensorData tensor{ type, std::move(shape), {} };
  tensor.Bytes.resize(values.size() * sizeof(Number));
  unsigned char* to = tensor.Bytes.data();
  for (const Number value : values)
  {
    std::uint64_t bits = 0;
    if constexpr (sizeof(Number) == 4)
    {
      std::uint32_t word;
      std::memcpy(&word, &value, sizeof(word));
      bits = word;
    }
    else
    {
      std::memcpy(&bits, &value, sizeof(bits));
    }
    for (std::size_t k = 0; k < sizeof(Number); ++k, bits >>= 8)
    {
      *to++ = static_cast<unsigned char>(bits & 0xFFU);
    }
  }
  return tensor;
}
} // namespace

TensorData TensorData::FromFloat32(std::vector<std::int64_t> shape, const std::vector<float>& values)
{
  return FromNumbers(TensorType::Float32, std::move(shape), values);
}

TensorData TensorData::FromFloat64(std::vector<std::int64_t> shape, const std::vector<double>& values)
{
  return FromNumbers(TensorType::Float64, std::move(shape), values);
}

TensorData TensorData::FromInt64(std::vector<std::int64_t> shape, const std::vector<std::int64_t>& values)
{
  return FromNumbers(TensorType::Int64, std::move(shape), values);
}

std::vector<unsigned char> SerializeSafetensors(
  const std::map<std::string, TensorData>& tensors, const std::map<std::string, std::string>& metadata)
{
  using Named = std::pair<const std::string, TensorData>;
  std::vector<const Named*> inOrder;
  for (const Named& tensor : tensors)
  {
    CheckTensor(tensor.first, tensor.second);
    inOrder.push_back(&tensor);
  }
  if (inOrder.size() > MaximumNumberOfTensors)
  {
    throw InvalidInput(
      "SerializeSafetensors: there are " + std::to_string(inOrder.size()) + " tensors; expected at most 100000.");
  }
  std::stable_sort(inOrder.begin(), inOrder.end(),
    [](const Named* a, const Named* b) { return ElementSize(a->second.Type) > ElementSize(b->second.Type); });

  std::string header = "{";
  if (!metadata.empty())
  {
    header += "\"__metadata__\":{";
    for (const auto& [key, value] : metadata)
    {
      header += (header.back() == '{' ? "" : ",") + Quoted(key) + ":" + Quoted(value);
    }
    header += "}";
  }
  std::size_t end = 0;
  for (const Named* tensor : inOrder)
  {
    header += (header.back() == '{' ? "" : ",") + Quoted(tensor->first) + ":" + EntryText(tensor->second, end);
    end += tensor->second.Bytes.size();
  }
  header += "}";
  header.append((HeaderStart - header.size() % HeaderStart) % HeaderStart, ' ');

  std::vector<unsigned char> bytes;
  bytes.reserve(HeaderStart + header.size() + end);
  for (std::size_t k = 0; k < HeaderStart; ++k)
  {
    bytes.push_back(static_cast<unsigned char>(header.size() >> (8 * k) & 0xFFU));
  }
  bytes.insert(bytes.end(), header.begin(), header.end());
  for (const Named* tensor : inOrder)
  {
    bytes.insert(bytes.end(), tensor->second.Bytes.begin(), tensor->second.Bytes.end());
  }
  return bytes;
}

void WriteSafetensors(const std::string& path, const std::map<std::string, TensorData>& tensors,
  const std::map<std::string, std::string>& metadata)
{
  const std::vector<unsigned char> bytes = SerializeSafetensors(tensors, metadata);
  WriteOutputFile(path, { reinterpret_cast<const char*>(bytes.data()), bytes.size() }, "WriteSafetensors");
}

} // namespace surfsynth
