// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentModel.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/Common/ModelFile.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace surfsynth
{

namespace
{
constexpr const char* FieldLatentArchitecture = "field_latents";
constexpr const char* DescriptionKey = "field_latents";
constexpr const char* FieldLatentKind = "a model of field latents, as surfacesynthesis-train writes it";

void ReadDescription(const SafetensorsFile& file, FieldLatentModel& model)
{
  const DescriptionReader reader(file, DescriptionKey);
  FieldLatentOptions& options = model.Options;
  options.LatentDimension = reader.WholeNumber("latent_dimension");
  options.Channels = reader.WholeNumber("channels");
  options.EncoderLayers = reader.WholeNumber("encoder_layers");
  options.Heads = reader.WholeNumber("heads");
  options.SamplesPerRing = reader.WholeNumber("samples_per_ring");
  options.DecoderLayers = reader.WholeNumber("decoder_layers");
  options.DecoderWidth = reader.WholeNumber("decoder_width");
  model.Iterations = reader.WholeNumber("iterations");
  const std::string coordinates = reader.String("coordinates");
  options.Coordinates = FieldLatentCoordinates::Logarithmic;
  if (coordinates == NameOf(FieldLatentCoordinates::Barycentric))
  {
    options.Coordinates = FieldLatentCoordinates::Barycentric;
  }
  else if (coordinates != NameOf(FieldLatentCoordinates::Logarithmic))
  {
    reader.Fail("coordinates", "\"logarithmic\" or \"barycentric\"");
  }
}

void CheckTensor(const std::string& name, const ModelTensor& tensor)
{
  const std::int64_t count = std::accumulate(
    tensor.Shape.begin(), tensor.Shape.end(), std::int64_t(1), std::multiplies<std::int64_t>());
  const bool finite = std::all_of(
    tensor.Values.begin(), tensor.Values.end(), [](float value) { return std::isfinite(value); });
  if (static_cast<std::int64_t>(tensor.Values.size()) != count || !finite)
  {
    throw InvalidInput("FieldLatentModel: \"" + name + "\" has " + std::to_string(tensor.Values.size()) + " numbers" +
      (finite ? "" : ", not all finite") + "; expected " + std::to_string(count) + " finite ones.");
  }
}
} // namespace

std::string FieldLatentModel::Description() const
{
  const FieldLatentOptions& o = this->Options;
  return "field latents of dimension " + std::to_string(o.LatentDimension) + ": encoder of " +
    std::to_string(o.EncoderLayers) + " layers with " + std::to_string(o.Channels) + " channels, " +
    std::to_string(o.SamplesPerRing) + " samples in a ring; decoder of " + std::to_string(o.DecoderLayers) +
    " layers with " + std::to_string(o.DecoderWidth) + " channels, " + NameOf(o.Coordinates) + " coordinates; " +
    std::to_string(this->Iterations) + " iterations";
}

void CheckModel(const FieldLatentModel& model)
{
  CheckOptions(model.Options);
  TensorShapes found;
  for (const auto& [name, tensor] : model.Tensors)
  {
    found[name] = tensor.Shape;
  }
  const std::string differences = DifferencesOf(ExpectedFieldLatentTensors(model.Options), found);
  if (!differences.empty())
  {
    throw InvalidInput("FieldLatentModel: the tensors are not those of the options: " + differences +
      "; expected those of ExpectedFieldLatentTensors().");
  }
  for (const auto& [name, tensor] : model.Tensors)
  {
    CheckTensor(name, tensor);
  }
}

std::string Fingerprint(const FieldLatentModel& model)
{
  std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a
  const auto add = [&hash](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t k = 0; k < size; ++k)
    {
      hash = (hash ^ bytes[k]) * 0x100000001b3;
    }
  };
  for (const auto& [name, tensor] : model.Tensors)
  {
    add(name.data(), name.size());
    add(tensor.Shape.data(), tensor.Shape.size() * sizeof(std::int64_t));
    add(tensor.Values.data(), tensor.Values.size() * sizeof(float));
  }
  std::string digits;
  for (int shift = 60; shift >= 0; shift -= 4)
  {
    digits += "0123456789abcdef"[hash >> shift & 15];
  }
  return digits;
}

FieldLatentModel ReadFieldLatents(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireArchitecture(file, FieldLatentArchitecture, FieldLatentKind);
  FieldLatentModel model;
  model.Metadata = file.Metadata();
  ReadDescription(file, model);
  try
  {
    CheckOptions(model.Options); // before anything is as large as they say
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  RequireTensors(file, ExpectedFieldLatentTensors(model.Options), "the field latents that the metadata describe");
  for (const auto& [name, entry] : file.Tensors())
  {
    model.Tensors[name] = { entry.Shape, file.Float32(name) };
  }
  return model;
}

void WriteFieldLatents(const std::string& path, const FieldLatentModel& model)
{
  CheckModel(model);
  std::map<std::string, TensorData> tensors;
  for (const auto& [name, tensor] : model.Tensors)
  {
    tensors[name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  const FieldLatentOptions& options = model.Options;
  std::map<std::string, std::string> metadata = model.Metadata;
  metadata["architecture"] = FieldLatentArchitecture;
  metadata["format_version"] = ModelFormatVersion;
  metadata["producer"] = "SurfaceSynthesis";
  metadata[DescriptionKey] = nlohmann::json(
    { { "latent_dimension", options.LatentDimension }, { "channels", options.Channels },
      { "encoder_layers", options.EncoderLayers }, { "heads", options.Heads },
      { "samples_per_ring", options.SamplesPerRing }, { "decoder_layers", options.DecoderLayers },
      { "decoder_width", options.DecoderWidth }, { "coordinates", NameOf(options.Coordinates) },
      { "iterations",
        model.Iterations } }).dump();
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
