// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionModel.h"

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
constexpr const char* DiffusionArchitecture = "field_latent_diffusion";
constexpr const char* DiffusionKey = "field_latent_diffusion";
constexpr const char* DiffusionKind = "a diffusion model of field latents";
constexpr const char* AutoencoderKey = "autoencoder";

void ReadDescription(const SafetensorsFile& file, LatentDiffusionModel& model)
{
  const DescriptionReader reader(file, DiffusionKey);
  LatentDiffusionOptions& options = model.Options;
  options.LatentDimension = reader.WholeNumber("latent_dimension");
  options.Channels = reader.WholeNumber("channels");
  options.CoarseChannels = reader.WholeNumber("coarse_channels");
  options.InputBlocks = reader.WholeNumber("input_blocks");
  options.CoarseBlocks = reader.WholeNumber("coarse_blocks");
  options.OutputBlocks = reader.WholeNumber("output_blocks");
  options.EmbeddingDimension = reader.WholeNumber("embedding_dimension");
  options.NumberOfLabels = reader.WholeNumber("labels");
  options.TimeSteps = reader.WholeNumber("time_steps");
  options.FirstVariance = reader.Number("first_variance");
  options.LastVariance = reader.Number("last_variance");
  model.Iterations = reader.WholeNumber("iterations");
  const double points = reader.NumberOr("training_points", 0.0);
  if (!(points >= 0.0 && points < 2147483648.0))
  {
    reader.Fail("training_points", "a number from 0 to 2147483647");
  }
  model.TrainingPoints = std::llround(points);
  const std::int64_t directed = reader.WholeNumber("directed");
  if (directed != 0 && directed != 1)
  {
    reader.Fail("directed", "0 or 1");
  }
  options.Directed = directed == 1;
  const std::string target = reader.String("target");
  for (const DiffusionTarget known : { DiffusionTarget::Noise, DiffusionTarget::Data, DiffusionTarget::Velocity })
  {
    if (target == NameOf(known))
    {
      options.Target = known;
      return;
    }
  }
  reader.Fail("target", "\"noise\", \"data\" or \"velocity\"");
}

void CheckDiffusionTensor(const std::string& name, const ModelTensor& tensor)
{
  const std::int64_t count = std::accumulate(
    tensor.Shape.begin(), tensor.Shape.end(), std::int64_t(1), std::multiplies<std::int64_t>());
  const bool finite = std::all_of(
    tensor.Values.begin(), tensor.Values.end(), [](float value) { return std::isfinite(value); });
  if (static_cast<std::int64_t>(tensor.Values.size()) != count || !finite)
  {
    throw InvalidInput("LatentDiffusionModel: \"" + name + "\" has " + std::to_string(tensor.Values.size()) +
      " numbers" + (finite ? "" : ", not all finite") + "; expected " + std::to_string(count) + " finite ones.");
  }
}

/// Factors of equation 39.
void CheckScale(const LatentDiffusionModel& model)
{
  const std::vector<float>& scale = model.Tensors.at("latent_scale").Values;
  if (std::any_of(scale.begin(), scale.end(), [](float value) { return !(value > 0.0F); }))
  {
    throw InvalidInput("LatentDiffusionModel: latent_scale has a number that is not larger than 0; expected factors of "
                       "equation 39.");
  }
}
} // namespace

std::string LatentDiffusionModel::Description() const
{
  const LatentDiffusionOptions& o = this->Options;
  return "diffusion of field latents of dimension " + std::to_string(o.LatentDimension) + ": " +
    std::to_string(o.InputBlocks) + " + " + std::to_string(o.CoarseBlocks) + " + " + std::to_string(o.OutputBlocks) +
    " blocks with " + std::to_string(o.Channels) + " and " + std::to_string(o.CoarseChannels) + " channels, " +
    std::to_string(o.NumberOfLabels) + " labels, " + (o.Directed ? "directed, " : "") + NameOf(o.Target) +
    " predicted in " + std::to_string(o.TimeSteps) + " time steps; " + std::to_string(this->Iterations) + " iterations";
}

void CheckModel(const LatentDiffusionModel& model)
{
  CheckOptions(model.Options);
  TensorShapes found;
  for (const auto& [name, tensor] : model.Tensors)
  {
    found[name] = tensor.Shape;
  }
  const std::string differences = DifferencesOf(ExpectedLatentDiffusionTensors(model.Options), found);
  if (!differences.empty())
  {
    throw InvalidInput("LatentDiffusionModel: the tensors are not those of the options: " + differences +
      "; expected those of ExpectedLatentDiffusionTensors().");
  }
  for (const auto& [name, tensor] : model.Tensors)
  {
    CheckDiffusionTensor(name, tensor);
  }
  CheckScale(model);
}

LatentDiffusionModel ReadLatentDiffusion(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireArchitecture(file, DiffusionArchitecture, DiffusionKind);
  LatentDiffusionModel model;
  model.Metadata = file.Metadata();
  const auto autoencoder = model.Metadata.find(AutoencoderKey);
  model.Autoencoder = autoencoder == model.Metadata.end() ? "" : autoencoder->second;
  ReadDescription(file, model);
  try
  {
    CheckOptions(model.Options); // before anything is as large as they say
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  RequireTensors(file, ExpectedLatentDiffusionTensors(model.Options), "the diffusion model that the metadata describe");
  for (const auto& [name, entry] : file.Tensors())
  {
    model.Tensors[name] = { entry.Shape, file.Float32(name) };
  }
  try
  {
    CheckScale(model);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  return model;
}

void WriteLatentDiffusion(const std::string& path, const LatentDiffusionModel& model)
{
  CheckModel(model);
  std::map<std::string, TensorData> tensors;
  for (const auto& [name, tensor] : model.Tensors)
  {
    tensors[name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  const LatentDiffusionOptions& o = model.Options;
  std::map<std::string, std::string> metadata = model.Metadata;
  metadata["architecture"] = DiffusionArchitecture;
  metadata["format_version"] = ModelFormatVersion;
  metadata["producer"] = "SurfaceSynthesis";
  metadata[DiffusionKey] = nlohmann::json(
    { { "latent_dimension", o.LatentDimension }, { "channels", o.Channels }, { "coarse_channels", o.CoarseChannels },
      { "input_blocks", o.InputBlocks }, { "coarse_blocks", o.CoarseBlocks }, { "output_blocks", o.OutputBlocks },
      { "embedding_dimension", o.EmbeddingDimension }, { "labels", o.NumberOfLabels },
      { "directed", o.Directed ? 1 : 0 }, { "time_steps", o.TimeSteps }, { "first_variance", o.FirstVariance },
      { "last_variance", o.LastVariance }, { "target", NameOf(o.Target) }, { "iterations", model.Iterations },
      { "training_points", model.TrainingPoints } })
                             .dump();
  metadata.erase(AutoencoderKey);
  if (!model.Autoencoder.empty())
  {
    metadata[AutoencoderKey] = model.Autoencoder;
  }
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
