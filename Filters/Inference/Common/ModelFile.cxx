// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/ModelFile.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace surfsynth
{

std::string DifferencesOf(const TensorShapes& expected, const TensorShapes& found)
{
  std::vector<std::string> differences;
  for (const auto& [name, shape] : expected)
  {
    const auto entry = found.find(name);
    if (entry == found.end())
    {
      differences.push_back("\"" + name + "\" " + FormatShape(shape) + " is missing");
    }
    else if (entry->second != shape)
    {
      differences.push_back("\"" + name + "\" is " + FormatShape(entry->second) + " instead of " + FormatShape(shape));
    }
  }
  for (const auto& entry : found)
  {
    if (expected.count(entry.first) == 0)
    {
      differences.push_back("\"" + entry.first + "\" does not belong to it");
    }
  }
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(differences.size(), 3); ++k)
  {
    text += (k > 0 ? "; " : "") + differences[k];
  }
  if (differences.size() > 3)
  {
    text += "; and " + std::to_string(differences.size() - 3) + " more";
  }
  return text;
}

void RequireArchitecture(
  const SafetensorsFile& file, const std::string& architecture, const std::string& kind, const std::string& newest)
{
  const auto require = [&](const std::string& key, const std::set<std::string>& expected) {
    const auto found = file.Metadata().find(key);
    if (found == file.Metadata().end() || expected.count(found->second) == 0)
    {
      std::string known;
      for (const std::string& value : expected)
      {
        known += (known.empty() ? "\"" : " or \"") + value + "\"";
      }
      throw ModelMismatch(file.Name() + ": the metadata \"" + key + "\" is " +
        (found == file.Metadata().end() ? "missing" : "\"" + found->second + "\"") + "; expected " + known + ": " +
        kind + ".");
    }
  };
  require("architecture", { architecture });
  require("format_version", { ModelFormatVersion, newest });
}

void RequireModelSize(const SafetensorsFile& file)
{
  std::int64_t count = 0;
  for (const auto& entry : file.Tensors())
  {
    count += entry.second.NumberOfElements();
  }
  if (count > MaximumModelSize)
  {
    throw ModelMismatch(file.Name() + ": the model has " + std::to_string(count) + " numbers; expected at most " +
      std::to_string(MaximumModelSize) + ".");
  }
}

TensorShapes ShapesIn(const SafetensorsFile& file)
{
  TensorShapes shapes;
  for (const auto& [name, entry] : file.Tensors())
  {
    shapes[name] = entry.Shape;
  }
  return shapes;
}

std::int64_t RowsIn(const SafetensorsFile& file, const std::string& tensor)
{
  const bool hasRows = file.Contains(tensor) && !file.Entry(tensor).Shape.empty();
  return hasRows ? file.Entry(tensor).Shape.front() : 1;
}

void RequireTensors(
  const SafetensorsFile& file, const TensorShapes& expected, const std::string& kind, const std::string& integers)
{
  const std::string differences = DifferencesOf(expected, ShapesIn(file));
  if (!differences.empty())
  {
    throw ModelMismatch(file.Name() + ": the tensors are not those of " + kind + ": " + differences + ".");
  }
  RequireModelSize(file);
  for (const auto& entry : file.Tensors())
  {
    if (entry.first != integers)
    {
      file.RequireFinite(entry.first);
    }
  }
}

PointMatrix ReadPoints(const SafetensorsFile& file, const std::string& tensor)
{
  const std::vector<double> values = file.Float64(tensor);
  return Eigen::Map<const PointMatrix>(values.data(), file.Entry(tensor).Shape[0], 3);
}

TriangleMatrix ReadTriangles(const SafetensorsFile& file, const std::string& tensor)
{
  const std::vector<std::int64_t> ids = file.Integers(tensor);
  TriangleMatrix triangles(file.Entry(tensor).Shape[0], 3);
  std::transform(ids.begin(), ids.end(), triangles.data(), [](std::int64_t id) {
    return id > std::numeric_limits<Index>::max() ? Index(-1) : static_cast<Index>(std::max<std::int64_t>(id, -1));
  });
  return triangles;
}

DescriptionReader::DescriptionReader(const SafetensorsFile& file, std::string key)
  : File(file.Name())
  , Key(std::move(key))
{
  const auto found = file.Metadata().find(this->Key);
  if (found != file.Metadata().end())
  {
    this->Json = nlohmann::json::parse(found->second, nullptr, false);
  }
  if (!this->Json.is_object())
  {
    throw ModelMismatch(this->File + ": the metadata \"" + this->Key + "\" is " +
      (found == file.Metadata().end() ? "missing" : "no JSON object") + "; expected a JSON object.");
  }
}

double DescriptionReader::Number(const char* key) const
{
  const auto found = this->Json.find(key);
  if (found == this->Json.end() || !found->is_number() || !std::isfinite(found->get<double>()))
  {
    this->Fail(key, "a number");
  }
  return found->get<double>();
}

double DescriptionReader::NumberOr(const char* key, double otherwise) const
{
  return this->Json.contains(key) ? this->Number(key) : otherwise;
}

std::int64_t DescriptionReader::WholeNumber(const char* key) const
{
  const double number = this->Number(key);
  if (number < 0.0 || number > 1e15 || number != std::floor(number))
  {
    this->Fail(key, "a whole number below 1e15");
  }
  return static_cast<std::int64_t>(number);
}

std::string DescriptionReader::String(const char* key) const
{
  const auto found = this->Json.find(key);
  if (found == this->Json.end() || !found->is_string() || found->get<std::string>().empty())
  {
    this->Fail(key, "a name");
  }
  return found->get<std::string>();
}

std::string DescriptionReader::StringOr(const char* key, const std::string& otherwise) const
{
  return this->Json.contains(key) ? this->String(key) : otherwise;
}

std::vector<double> DescriptionReader::Numbers(const char* key) const
{
  const auto found = this->Json.find(key);
  if (found == this->Json.end() || !found->is_array() ||
    !std::all_of(found->begin(), found->end(), [](const nlohmann::json& entry) { return entry.is_number(); }))
  {
    this->Fail(key, "an array of numbers");
  }
  return found->get<std::vector<double>>();
}

void DescriptionReader::Fail(const std::string& key, const std::string& expected) const
{
  const auto found = this->Json.find(key);
  throw ModelMismatch(this->File + ": \"" + key + "\" in the metadata \"" + this->Key + "\" is " +
    (found == this->Json.end() ? "missing" : found->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) +
    "; expected " + expected + ".");
}

} // namespace surfsynth
