// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/PoissonNetModel.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/Common/ModelFile.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <numeric>
#include <sstream>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* PoissonNetArchitecture = "poissonnet";

const std::pair<const char*, InputNormalization> NormalizationNames[] = { { "none", InputNormalization::None },
  { "surface_area", InputNormalization::SurfaceArea }, { "unit_sphere", InputNormalization::UnitSphere } };

using Metadata = std::map<std::string, std::string>;

/// Throws unless the key is absent or has that value.
void RequireValue(
  const std::string& file, const Metadata& metadata, const std::string& key, const std::string& expected)
{
  const auto found = metadata.find(key);
  if (found != metadata.end() && found->second != expected)
  {
    throw ModelMismatch(
      file + ": the metadata \"" + key + "\" is \"" + found->second + "\"; expected \"" + expected + "\".");
  }
}

std::vector<std::string> ParseClasses(const std::string& file, const std::string& text)
{
  std::vector<std::string> classes;
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_array())
  {
    for (const nlohmann::json& name : json)
    {
      if (!name.is_string())
      {
        throw ModelMismatch(file + ": the metadata \"classes\" holds something else than strings; expected names.");
      }
      classes.push_back(name.get<std::string>());
    }
    return classes;
  }
  std::istringstream stream(text);
  for (std::string name; std::getline(stream, name, ',');)
  {
    const std::size_t first = name.find_first_not_of(' ');
    classes.push_back(first == std::string::npos ? "" : name.substr(first, name.find_last_not_of(' ') - first + 1));
  }
  return classes;
}

InputNormalization ParseNormalization(const std::string& file, const std::string& text)
{
  for (const auto& [name, value] : NormalizationNames)
  {
    if (text == name)
    {
      return value;
    }
  }
  throw ModelMismatch(
    file + ": the metadata \"input_normalisation\" is \"" + text + "\"; expected none, surface_area or unit_sphere.");
}

void ReadDescription(const std::string& file, PoissonNetModel& model)
{
  RequireValue(file, model.Metadata, "architecture", PoissonNetArchitecture);
  RequireValue(file, model.Metadata, "format_version", ModelFormatVersion);
  model.Options = OptionsFromMetadata(file, model.Metadata);
  if (const auto found = model.Metadata.find("input_normalisation"); found != model.Metadata.end())
  {
    model.Normalization = ParseNormalization(file, found->second);
  }
  if (const auto found = model.Metadata.find("classes"); found != model.Metadata.end())
  {
    model.Classes = ParseClasses(file, found->second);
    if (static_cast<std::int64_t>(model.Classes.size()) != model.Options.ResultChannels())
    {
      throw ModelMismatch(file + ": the metadata \"classes\" has " + std::to_string(model.Classes.size()) +
        " names; expected " + std::to_string(model.Options.ResultChannels()) + ", one for each output channel.");
    }
  }
}

/// The network that @p metadata describe, with the tensors whose names begin with @p prefix.
PoissonNetModel ReadNetwork(
  const SafetensorsFile& file, const std::string& name, Metadata metadata, const std::string& prefix)
{
  PoissonNetModel model;
  model.Metadata = std::move(metadata);
  ReadDescription(name, model);
  TensorShapes found;
  for (const auto& [tensor, entry] : file.Tensors())
  {
    if (tensor.rfind(prefix, 0) == 0)
    {
      found[tensor.substr(prefix.size())] = entry.Shape;
    }
  }
  const std::string differences = DifferencesOf(ExpectedTensors(model.Options), found);
  if (!differences.empty())
  {
    throw ModelMismatch(
      name + ": the tensors are not those of the network that the metadata describe: " + differences + ".");
  }
  RequireModelSize(file);
  for (auto& [tensor, shape] : found)
  {
    file.RequireFinite(prefix + tensor);
    model.Tensors[tensor] = { std::move(shape), file.Float32(prefix + tensor) };
  }
  return model;
}

/// Result of ReadDescription().
Metadata Describe(const PoissonNetModel& model)
{
  Metadata metadata = model.Metadata;
  for (const auto& [key, value] : MetadataFromOptions(model.Options))
  {
    metadata[key] = value;
  }
  metadata["architecture"] = PoissonNetArchitecture;
  metadata["format_version"] = ModelFormatVersion;
  for (const auto& [name, value] : NormalizationNames)
  {
    if (value == model.Normalization)
    {
      metadata["input_normalisation"] = name;
    }
  }
  metadata.erase("classes");
  if (!model.Classes.empty())
  {
    metadata["classes"] = nlohmann::json(model.Classes).dump();
  }
  return metadata;
}
} // namespace

PoissonNetModel ReadPoissonNet(const std::string& path) { return ReadPoissonNet(SafetensorsFile(path)); }

PoissonNetModel ReadPoissonNet(const SafetensorsFile& file, const std::string& prefix)
{
  return ReadNetwork(file, file.Name(), file.Metadata(), prefix);
}

PoissonNetModel ReadPartNetwork(const SafetensorsFile& file, const std::string& part)
{
  const auto found = file.Metadata().find(part);
  const nlohmann::json json = found == file.Metadata().end() ? nlohmann::json()
                                                             : nlohmann::json::parse(found->second, nullptr, false);
  Metadata metadata;
  bool valid = json.is_object();
  for (auto entry = json.begin(); valid && entry != json.end(); ++entry)
  {
    valid = entry->is_string();
    metadata[entry.key()] = valid ? entry->get<std::string>() : "";
  }
  if (!valid)
  {
    throw ModelMismatch(file.Name() + ": the metadata \"" + part + "\" is " +
      (found == file.Metadata().end() ? "missing" : "something else") +
      "; expected a JSON object of strings that describes a network.");
  }
  return ReadNetwork(file, file.Name() + " (" + part + ")", std::move(metadata), part + ".");
}

void CheckModel(const PoissonNetModel& model)
{
  TensorShapes shapes;
  for (const auto& [name, tensor] : model.Tensors)
  {
    shapes[name] = tensor.Shape;
  }
  const std::string differences = DifferencesOf(ExpectedTensors(model.Options), shapes);
  if (!differences.empty())
  {
    throw InvalidInput("PoissonNetModel: the tensors are not those of the options: " + differences + ".");
  }
  for (const auto& [name, tensor] : model.Tensors)
  {
    const std::int64_t count = std::accumulate(
      tensor.Shape.begin(), tensor.Shape.end(), std::int64_t(1), std::multiplies<std::int64_t>());
    if (static_cast<std::int64_t>(tensor.Values.size()) != count)
    {
      throw InvalidInput("PoissonNetModel: \"" + name + "\" has " + std::to_string(tensor.Values.size()) +
        " numbers; expected " + std::to_string(count) + ".");
    }
  }
}

void AddPartNetwork(const std::string& part, const PoissonNetModel& model, std::map<std::string, TensorData>& tensors,
  std::map<std::string, std::string>& metadata)
{
  CheckModel(model);
  for (const auto& [name, tensor] : model.Tensors)
  {
    tensors[part + "." + name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  metadata[part] = nlohmann::json(Describe(model)).dump();
}

void WritePoissonNet(const std::string& path, const PoissonNetModel& model)
{
  CheckModel(model);
  std::map<std::string, TensorData> tensors;
  for (const auto& [name, tensor] : model.Tensors)
  {
    tensors[name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  Metadata metadata = Describe(model);
  metadata["producer"] = "SurfaceSynthesis";
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
