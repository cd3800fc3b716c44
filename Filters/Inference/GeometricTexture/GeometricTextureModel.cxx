// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/Common/ModelFile.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* GeometricTextureArchitecture = "geometric_texture";
constexpr const char* TextureKey = "geometric_texture";
constexpr const char* Kind = "a geometric texture, as vtkGeometricTextureTrainer writes it";
constexpr const char* DiscriminatorPrefix = "discriminator.";
constexpr const char* StatisticsPrefix = "statistics.";
constexpr const char* PointsName = "template.points";
constexpr const char* TrianglesName = "template.triangles";
constexpr const char* NoiseName = "reconstruction_noise";
constexpr const char* FlowStepsKey = "flow_steps";
constexpr const char* FlowFormatVersion = "2"; ///< of models whose networks are velocities

/// Largest GeometricTextureOptions::FlowSteps.
constexpr std::int64_t MaximumFlowSteps = 1000;

constexpr std::int64_t EdgeChannels = 4;
constexpr std::int64_t GeneratorOutputs = 3;
constexpr std::int64_t DiscriminatorOutputs = 1;

[[noreturn]] void RefuseTexture(const std::string& found, const std::string& expected)
{
  throw InvalidInput("GeometricTextureModel: " + found + "; expected " + expected + ".");
}

GeometricTextureChannels ChannelsOf(const GeometricTextureOptions& options, std::int64_t level, std::int64_t outputs)
{
  GeometricTextureChannels channels(1, EdgeChannels);
  std::int64_t widest = options.StartChannels;
  for (std::int64_t k = 0; k < level && widest < options.MaximumChannels; ++k)
  {
    widest *= 2;
  }
  widest = std::min(widest, options.MaximumChannels);
  for (std::int64_t i = 1; i <= options.Layers - 2; ++i)
  {
    channels.push_back(std::max(widest >> (i - 1), options.MinimumChannels));
  }
  channels.push_back(outputs);
  return channels;
}

bool HasTensorsOf(const SafetensorsFile& file, const std::string& prefix)
{
  const auto first = file.Tensors().lower_bound(prefix);
  return first != file.Tensors().end() && first->first.compare(0, prefix.size(), prefix) == 0;
}

/// Shapes of the tensors that @p file must hold, given its optional parts.
TensorShapes ExpectedInFile(const SafetensorsFile& file, const GeometricTextureOptions& options)
{
  TensorShapes expected = ExpectedGeometricTextureTensors(options, false);
  const auto add = [&](const char* prefix, const TensorShapes& shapes) {
    for (const auto& [name, shape] : HasTensorsOf(file, prefix) ? shapes : TensorShapes())
    {
      expected[prefix + name] = shape;
    }
  };
  add(DiscriminatorPrefix, ExpectedGeometricTextureTensors(options, true));
  add(StatisticsPrefix, ExpectedGeometricTextureStatistics(options));
  if (file.Contains(PointsName) || file.Contains(TrianglesName) || file.Contains(NoiseName))
  {
    expected[PointsName] = expected[NoiseName] = { RowsIn(file, PointsName), 3 };
    expected[TrianglesName] = { RowsIn(file, TrianglesName), 3 };
  }
  return expected;
}

void ReadOptions(const SafetensorsFile& file, GeometricTextureModel& model)
{
  const DescriptionReader reader(file, TextureKey);
  model.Name = reader.String("name");
  model.Options.Levels = reader.WholeNumber("levels");
  model.Options.Layers = reader.WholeNumber("layers");
  model.Options.StartChannels = reader.WholeNumber("start_channels");
  model.Options.MinimumChannels = reader.WholeNumber("least_channels");
  model.Options.MaximumChannels = reader.WholeNumber("most_channels");
  model.Options.NoiseAmplitude = reader.Number("noise_amplitude");
  const bool isFlow = model.Metadata.at("format_version") == FlowFormatVersion;
  model.Options.FlowSteps = isFlow ? reader.WholeNumber(FlowStepsKey) : 0;
  if (isFlow && model.Options.FlowSteps == 0)
  {
    reader.Fail(FlowStepsKey, "1 to 1000");
  }
}

std::map<std::string, ModelTensor> ReadTensors(
  const SafetensorsFile& file, const TensorShapes& expected, const std::string& prefix)
{
  std::map<std::string, ModelTensor> tensors;
  for (const auto& [name, shape] : expected)
  {
    tensors[name] = { shape, file.Float32(prefix + name) };
  }
  return tensors;
}

void ReadTemplate(const SafetensorsFile& file, GeometricTextureModel& model)
{
  const std::vector<float> noise = file.Float32(NoiseName);
  model.Template = { ReadPoints(file, PointsName), ReadTriangles(file, TrianglesName) };
  model.ReconstructionNoise = Eigen::Map<const SinglePoints>(
    noise.data(), static_cast<Eigen::Index>(noise.size() / 3), 3);
}

void CheckTensors(const std::map<std::string, ModelTensor>& tensors, const TensorShapes& expected, const char* network,
  const char* expectedNames = "ExpectedGeometricTextureTensors()")
{
  TensorShapes found;
  for (const auto& [name, tensor] : tensors)
  {
    found[name] = tensor.Shape;
  }
  const std::string differences = DifferencesOf(expected, found);
  if (!differences.empty())
  {
    RefuseTexture(std::string("the tensors of the ") + network + " are not those of the options: " + differences,
      std::string("those of ") + expectedNames);
  }
  for (const auto& [name, tensor] : tensors)
  {
    std::int64_t count = 1;
    for (const std::int64_t extent : tensor.Shape)
    {
      count *= extent;
    }
    const bool finite = std::all_of(
      tensor.Values.begin(), tensor.Values.end(), [](float value) { return std::isfinite(value); });
    if (static_cast<std::int64_t>(tensor.Values.size()) != count || !finite)
    {
      RefuseTexture("\"" + name + "\" of the " + network + " has " + std::to_string(tensor.Values.size()) + " numbers" +
          (finite ? "" : ", not all finite"),
        std::to_string(count) + " finite ones");
    }
  }
}

void CheckStatistics(const GeometricTextureModel& model)
{
  CheckTensors(model.Statistics, ExpectedGeometricTextureStatistics(model.Options), "normalized channels",
    "ExpectedGeometricTextureStatistics()");
  for (std::int64_t level = 0; level < model.Options.Levels; ++level)
  {
    for (std::int64_t j = 0; j < model.Options.Layers - 2; ++j)
    {
      const std::string name = NamesOfStatistics(level, j).Variance;
      const std::vector<float>& variances = model.Statistics.at(name).Values;
      if (*std::min_element(variances.begin(), variances.end()) < 0.0F)
      {
        RefuseTexture("\"" + name + "\" has a number below 0", "variances");
      }
    }
  }
}

void CheckTemplate(const GeometricTextureModel& model)
{
  const TriangleMesh& mesh = model.Template;
  if (mesh.NumberOfTriangles() == 0 && mesh.NumberOfPoints() == 0 && model.ReconstructionNoise.rows() == 0)
  {
    return;
  }
  if (mesh.NumberOfTriangles() == 0 || model.ReconstructionNoise.rows() != mesh.NumberOfPoints() ||
    !model.ReconstructionNoise.allFinite() || !mesh.Points.allFinite())
  {
    RefuseTexture("the template has " + std::to_string(mesh.NumberOfTriangles()) + " triangles on " +
        std::to_string(mesh.NumberOfPoints()) + " points and noise at " +
        std::to_string(model.ReconstructionNoise.rows()),
      "triangles, and finite noise at each of its finite points");
  }
  const std::vector<MeshFinding> findings = CheckMesh(mesh, GeometricTextureSampler::Requirements());
  if (!findings.empty())
  {
    RefuseTexture("the template is broken: " + DescribeFindings(findings), "a mesh that a texture can grow on");
  }
}

void AddTensors(
  const std::map<std::string, ModelTensor>& tensors, const std::string& prefix, std::map<std::string, TensorData>& data)
{
  for (const auto& [name, tensor] : tensors)
  {
    data[prefix + name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
}

void AddTemplate(const GeometricTextureModel& model, std::map<std::string, TensorData>& data)
{
  const PointMatrix& points = model.Template.Points;
  const TriangleMatrix& triangles = model.Template.Triangles;
  const SinglePoints& noise = model.ReconstructionNoise;
  data[PointsName] = TensorData::FromFloat64(
    { points.rows(), 3 }, std::vector<double>(points.data(), points.data() + points.size()));
  data[TrianglesName] = TensorData::FromInt64(
    { triangles.rows(), 3 }, std::vector<std::int64_t>(triangles.data(), triangles.data() + triangles.size()));
  data[NoiseName] = TensorData::FromFloat32(
    { noise.rows(), 3 }, std::vector<float>(noise.data(), noise.data() + noise.size()));
}
} // namespace

GeometricTextureChannels GeometricTextureOptions::GeneratorChannels(std::int64_t level) const
{
  return ChannelsOf(*this, level, GeneratorOutputs);
}

GeometricTextureChannels GeometricTextureOptions::DiscriminatorChannels(std::int64_t level) const
{
  return ChannelsOf(*this, level, DiscriminatorOutputs);
}

void CheckOptions(const GeometricTextureOptions& options)
{
  const struct
  {
    const char* Name;
    std::int64_t Value;
    std::int64_t Minimum;
    std::int64_t Maximum;
  } ranges[] = { { "levels", options.Levels, 1, 16 }, { "layers", options.Layers, 3, 32 },
    { "start_channels", options.StartChannels, 1, 4096 }, { "least_channels", options.MinimumChannels, 1, 4096 },
    { "most_channels", options.MaximumChannels, 1, 4096 }, { FlowStepsKey, options.FlowSteps, 0, MaximumFlowSteps } };
  for (const auto& range : ranges)
  {
    if (range.Value < range.Minimum || range.Value > range.Maximum)
    {
      RefuseTexture(std::string(range.Name) + " is " + std::to_string(range.Value),
        std::to_string(range.Minimum) + " to " + std::to_string(range.Maximum));
    }
  }
  if (!(options.NoiseAmplitude >= 0.0) || !std::isfinite(static_cast<float>(options.NoiseAmplitude)))
  {
    RefuseTexture("noise_amplitude is " + FormatNumber(options.NoiseAmplitude), "a finite number of at least 0");
  }
}

GeometricTextureTensorNames NamesOfConvolution(std::int64_t level, std::int64_t convolution, std::int64_t layers)
{
  // All but the last stand in a sequence with their norm and activation.
  const std::string name = "levels." + std::to_string(level) + ".layers." + std::to_string(convolution) +
    (convolution == layers - 2 ? ".conv." : ".0.conv.");
  return { name + "weight", name + "bias" };
}

std::map<std::string, std::vector<std::int64_t>> ExpectedGeometricTextureTensors(
  const GeometricTextureOptions& options, bool discriminator)
{
  TensorShapes shapes;
  for (std::int64_t level = 0; level < options.Levels; ++level)
  {
    const GeometricTextureChannels channels = discriminator ? options.DiscriminatorChannels(level)
                                                            : options.GeneratorChannels(level);
    for (std::int64_t j = 0; j < options.Layers - 1; ++j)
    {
      const GeometricTextureTensorNames names = NamesOfConvolution(level, j, options.Layers);
      shapes[names.Weight] = { channels[j + 1], j == 0 ? channels[0] : 2 * channels[j], 1 };
      shapes[names.Bias] = { channels[j + 1] };
    }
  }
  return shapes;
}

GeometricTextureStatisticsNames NamesOfStatistics(std::int64_t level, std::int64_t convolution)
{
  const std::string name = "levels." + std::to_string(level) + ".layers." + std::to_string(convolution);
  return { name + ".mean", name + ".variance" };
}

std::map<std::string, std::vector<std::int64_t>> ExpectedGeometricTextureStatistics(
  const GeometricTextureOptions& options)
{
  TensorShapes shapes;
  for (std::int64_t level = 0; level < options.Levels; ++level)
  {
    const GeometricTextureChannels channels = options.GeneratorChannels(level);
    for (std::int64_t j = 0; j < options.Layers - 2; ++j)
    {
      const GeometricTextureStatisticsNames names = NamesOfStatistics(level, j);
      const bool isFlow = options.FlowSteps > 0;
      shapes[names.Mean] = shapes[names.Variance] = isFlow
        ? std::vector<std::int64_t>{ options.FlowSteps, channels[j + 1] }
        : std::vector<std::int64_t>{ channels[j + 1] };
    }
  }
  return shapes;
}

std::string GeometricTextureModel::Description() const
{
  const GeometricTextureChannels channels = this->Options.GeneratorChannels(this->Options.Levels - 1);
  const std::int64_t triangles = this->Template.NumberOfTriangles();
  return "\"" + this->Name + "\": " + std::to_string(this->Options.Levels) + " levels of " +
    std::to_string(this->Options.Layers - 1) + " convolutions with up to " +
    std::to_string(*std::max_element(channels.begin(), channels.end())) + " channels; " +
    (this->Options.FlowSteps > 0 ? "flow of " + std::to_string(this->Options.FlowSteps) + " steps; " : std::string()) +
    (triangles == 0 ? std::string("without a template") : "template of " + std::to_string(triangles) + " triangles");
}

GeometricTextureModel ReadGeometricTexture(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireArchitecture(file, GeometricTextureArchitecture, Kind, FlowFormatVersion);
  GeometricTextureModel model;
  model.Metadata = file.Metadata();
  ReadOptions(file, model);
  try
  {
    CheckOptions(model.Options); // before anything is as large as they say
    RequireTensors(
      file, ExpectedInFile(file, model.Options), "the geometric texture that the metadata describe", TrianglesName);
    model.Generator = ReadTensors(file, ExpectedGeometricTextureTensors(model.Options, false), "");
    if (HasTensorsOf(file, StatisticsPrefix))
    {
      model.Statistics = ReadTensors(file, ExpectedGeometricTextureStatistics(model.Options), StatisticsPrefix);
    }
    if (HasTensorsOf(file, DiscriminatorPrefix))
    {
      model.Discriminator = ReadTensors(
        file, ExpectedGeometricTextureTensors(model.Options, true), DiscriminatorPrefix);
    }
    if (file.Contains(PointsName))
    {
      ReadTemplate(file, model);
    }
    CheckModel(model);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  return model;
}

void CheckModel(const GeometricTextureModel& model)
{
  CheckOptions(model.Options);
  if (model.Name.empty())
  {
    RefuseTexture("it has no name", "a name");
  }
  CheckTensors(model.Generator, ExpectedGeometricTextureTensors(model.Options, false), "generator");
  if (!model.Discriminator.empty())
  {
    CheckTensors(model.Discriminator, ExpectedGeometricTextureTensors(model.Options, true), "discriminator");
  }
  if (!model.Statistics.empty())
  {
    CheckStatistics(model);
  }
  CheckTemplate(model);
}

void WriteGeometricTexture(const std::string& path, const GeometricTextureModel& model)
{
  CheckModel(model);
  std::map<std::string, TensorData> tensors;
  AddTensors(model.Generator, "", tensors);
  AddTensors(model.Discriminator, DiscriminatorPrefix, tensors);
  AddTensors(model.Statistics, StatisticsPrefix, tensors);
  if (model.Template.NumberOfTriangles() > 0)
  {
    AddTemplate(model, tensors);
  }
  const GeometricTextureOptions& options = model.Options;
  std::map<std::string, std::string> metadata = model.Metadata;
  metadata["architecture"] = GeometricTextureArchitecture;
  metadata["format_version"] = options.FlowSteps > 0 ? FlowFormatVersion : ModelFormatVersion;
  metadata["producer"] = "SurfaceSynthesis";
  nlohmann::json description = { { "name", model.Name }, { "levels", options.Levels }, { "layers", options.Layers },
    { "start_channels", options.StartChannels }, { "least_channels", options.MinimumChannels },
    { "most_channels", options.MaximumChannels }, { "noise_amplitude", options.NoiseAmplitude } };
  if (options.FlowSteps > 0)
  {
    description[FlowStepsKey] = options.FlowSteps;
  }
  metadata[TextureKey] = description.dump();
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
