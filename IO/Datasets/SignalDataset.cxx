// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/SignalDataset.h"

#include "Core/Common/Errors.h"
#include "IO/Datasets/DatasetFiles.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <limits>
#include <utility>

namespace surfsynth
{

namespace
{
using Shape = std::vector<std::int64_t>;

constexpr const char* SignalContent = "surface_signals";
constexpr const char* SignalKind = "as in the dataset files that \"python3 -m surfacesynthesis dataset\" writes";

std::string SourceTensor(std::size_t source, const char* part)
{
  return "sources." + std::to_string(source) + "." + part;
}

/// The shape of a tensor that must have @p rank dimensions, the last of them @p columns (0: any).
const Shape& RequireShape(const SafetensorsFile& file, const std::string& name, std::size_t rank, std::int64_t columns)
{
  const Shape& shape = file.Entry(name).Shape;
  if (shape.size() != rank || (columns > 0 && shape.back() != columns))
  {
    throw ModelMismatch(file.Name() + ": \"" + name + "\" has " + std::to_string(shape.size()) + " dimensions" +
      (shape.empty() ? "" : ", the last of " + std::to_string(shape.back())) + "; expected " + std::to_string(rank) +
      (columns > 0 ? ", the last of " + std::to_string(columns) : "") + ".");
  }
  return shape;
}

std::int64_t RequireVertices(const SafetensorsFile& file, const std::string& name, std::int64_t rows)
{
  if (rows > std::numeric_limits<Index>::max())
  {
    throw ModelMismatch(file.Name() + ": \"" + name + "\" has " + std::to_string(rows) + " rows; expected below 2^31.");
  }
  return rows;
}

/// Checks shapes and types of the tensors of a source, before they are read.
void RequireSource(const SafetensorsFile& file, std::size_t number)
{
  const std::string pointsName = SourceTensor(number, "points");
  const std::string trianglesName = SourceTensor(number, "triangles");
  const std::string signalsName = SourceTensor(number, "signals");
  const std::int64_t vertices = RequireVertices(file, pointsName, RequireShape(file, pointsName, 2, 3)[0]);
  RequireVertices(file, trianglesName, RequireShape(file, trianglesName, 2, 3)[0]);
  const Shape& shape = RequireShape(file, signalsName, 3, 0);
  file.RequireFloatingPoint(pointsName);
  file.RequireIntegers(trianglesName);
  file.RequireFloatingPoint(signalsName);
  if (shape[1] != vertices)
  {
    throw ModelMismatch(file.Name() + ": \"" + signalsName + "\" has signals at " + std::to_string(shape[1]) +
      " vertices; expected " + std::to_string(vertices) + ", one for each point.");
  }
}

SignalSource ReadSource(const SafetensorsFile& file, std::size_t number)
{
  const std::string trianglesName = SourceTensor(number, "triangles");
  const std::string signalsName = SourceTensor(number, "signals");
  const Shape& shape = file.Entry(signalsName).Shape;
  const std::int64_t vertices = shape[1];
  const std::int64_t faces = file.Entry(trianglesName).Shape[0];
  SignalSource source;
  const std::vector<double> points = file.Float64(SourceTensor(number, "points"));
  source.Mesh.Points = Eigen::Map<const PointMatrix>(points.data(), vertices, 3);
  source.Mesh.Triangles.resize(faces, 3);
  const std::vector<std::int64_t> ids = file.Integers(trianglesName);
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    if (ids[k] < 0 || ids[k] >= vertices)
    {
      throw ModelMismatch(file.Name() + ": \"" + trianglesName + "\" names vertex " + std::to_string(ids[k]) +
        "; expected ids from 0 to " + std::to_string(vertices - 1) + ".");
    }
    source.Mesh.Triangles.data()[k] = static_cast<Index>(ids[k]);
  }
  const std::vector<float> values = file.Float32(signalsName);
  source.Samples = Eigen::Map<const SignalSamples>(values.data(), shape[0], shape[1] * shape[2]);
  return source;
}

void CheckSource(const SignalDataset& dataset, std::size_t number)
{
  const SignalSource& source = dataset.Sources[number];
  const std::string where = "CheckDataset: source " + std::to_string(number);
  const std::int64_t vertices = source.Mesh.NumberOfPoints();
  const std::int64_t expected = dataset.HoldsPositions() ? 3 : dataset.NumberOfComponents();
  if (vertices == 0 || source.NumberOfSamples() == 0)
  {
    throw InvalidInput(where + " has " + std::to_string(vertices) + " vertices and " +
      std::to_string(source.NumberOfSamples()) + " samples; expected at least one of each.");
  }
  if (source.Samples.cols() % vertices != 0 || source.NumberOfComponents() != expected || expected == 0)
  {
    throw InvalidInput(where + " has " + std::to_string(source.Samples.cols()) + " numbers in each sample for " +
      std::to_string(vertices) + " vertices; expected " + std::to_string(expected) + " for each vertex.");
  }
  if (!source.Samples.allFinite())
  {
    throw InvalidInput(where + " has a sample with a number that is not finite; expected finite numbers.");
  }
}
} // namespace

std::int64_t SignalDataset::NumberOfSamples() const
{
  std::int64_t count = 0;
  for (const SignalSource& source : this->Sources)
  {
    count += source.NumberOfSamples();
  }
  return count;
}

void CheckDataset(const SignalDataset& dataset)
{
  if (dataset.Sources.empty())
  {
    throw InvalidInput("CheckDataset: the dataset has no surface; expected at least one.");
  }
  for (std::size_t k = 0; k < dataset.Sources.size(); ++k)
  {
    CheckSource(dataset, k);
  }
}

SignalDataset ReadSignalDataset(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireMetadata(file, "content", SignalContent, SignalKind);
  RequireMetadata(file, "format_version", DatasetFormatVersion, SignalKind);
  SignalDataset dataset;
  dataset.SignalName = RequireMetadata(file, "signal_name", "", SignalKind);
  const std::pair<const char*, std::string*> texts[] = { { "origin", &dataset.Origin },
    { "license", &dataset.License } };
  for (const auto& [key, text] : texts)
  {
    const auto found = file.Metadata().find(key);
    *text = found == file.Metadata().end() ? std::string() : found->second;
  }
  std::size_t sources = 0;
  for (; sources == 0 || file.Contains(SourceTensor(sources, "points")); ++sources)
  {
    RequireSource(file, sources);
  }
  file.RequireMemory(CopiesInMemory);
  for (std::size_t k = 0; k < sources; ++k)
  {
    dataset.Sources.push_back(ReadSource(file, k));
  }
  try
  {
    CheckDataset(dataset);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  return dataset;
}

void WriteSignalDataset(const std::string& path, const SignalDataset& dataset)
{
  CheckDataset(dataset);
  std::map<std::string, TensorData> tensors;
  for (std::size_t k = 0; k < dataset.Sources.size(); ++k)
  {
    const SignalSource& source = dataset.Sources[k];
    const auto begin = [](const auto& matrix) { return matrix.data(); };
    const auto end = [](const auto& matrix) { return matrix.data() + matrix.size(); };
    const std::int64_t vertices = source.Mesh.NumberOfPoints();
    tensors[SourceTensor(k, "points")] = TensorData::FromFloat64(
      { vertices, 3 }, std::vector<double>(begin(source.Mesh.Points), end(source.Mesh.Points)));
    tensors[SourceTensor(k, "triangles")] = TensorData::FromInt64({ source.Mesh.NumberOfTriangles(), 3 },
      std::vector<std::int64_t>(begin(source.Mesh.Triangles), end(source.Mesh.Triangles)));
    tensors[SourceTensor(k, "signals")] = TensorData::FromFloat32(
      { source.NumberOfSamples(), vertices, source.NumberOfComponents() },
      std::vector<float>(begin(source.Samples), end(source.Samples)));
  }
  std::map<std::string, std::string> metadata{ { "content", SignalContent }, { "format_version", DatasetFormatVersion },
    { "signal_name", dataset.SignalName }, { "producer", "SurfaceSynthesis" } };
  const std::pair<const char*, const std::string*> texts[] = { { "origin", &dataset.Origin },
    { "license", &dataset.License } };
  for (const auto& [key, text] : texts)
  {
    if (!text->empty())
    {
      metadata[key] = *text;
    }
  }
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
