// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/LatentDataset.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Operators/SurfaceOperators.h"
#include "IO/Datasets/DatasetFiles.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <algorithm>
#include <limits>
#include <map>

namespace surfsynth
{

namespace
{
constexpr const char* LatentContent = "field_latents";
constexpr const char* LatentKind = "as in the dataset files of field latents";
constexpr std::int32_t LargestLabel = 65535;

std::string SurfaceTensor(std::size_t surface, const char* part)
{
  return "surfaces." + std::to_string(surface) + "." + part;
}

[[noreturn]] void RefuseShape(const SafetensorsFile& file, const std::string& name, const std::string& expected)
{
  throw ModelMismatch(
    file.Name() + ": \"" + name + "\" is " + FormatShape(file.Entry(name).Shape) + "; expected " + expected + ".");
}

/// Checks that a tensor is a table with fewer than 2^31 rows, without reading it. Returns the numbers of rows and columns.
std::pair<std::int64_t, std::int64_t> RequireLatentTable(
  const SafetensorsFile& file, const std::string& name, bool floatingPoint)
{
  const std::vector<std::int64_t>& shape = file.Entry(name).Shape;
  if (shape.size() != 2 || shape[0] > std::numeric_limits<Index>::max())
  {
    RefuseShape(file, name, "[rows, columns] with fewer than 2^31 rows");
  }
  floatingPoint ? file.RequireFloatingPoint(name) : file.RequireIntegers(name);
  return { shape[0], shape[1] };
}

/// Checks shapes and types of the tensors of a surface, before they are read.
void RequireSurface(const SafetensorsFile& file, std::size_t surface)
{
  const auto name = [surface](const char* part) { return SurfaceTensor(surface, part); };
  const auto [rows, axes] = RequireLatentTable(file, name("points"), true);
  if (axes != 3)
  {
    RefuseShape(file, name("points"), "[vertices, 3]");
  }
  if (RequireLatentTable(file, name("triangles"), false).second != 3)
  {
    RefuseShape(file, name("triangles"), "[triangles, 3]");
  }
  const auto [deviations, dimension] = RequireLatentTable(file, name("deviations"), true);
  if (deviations != rows || dimension < 1)
  {
    RefuseShape(file, name("deviations"), "[" + std::to_string(rows) + ", d]");
  }
  const auto [means, columns] = RequireLatentTable(file, name("means"), true);
  if (means != rows || (columns != 2 * dimension && columns != 3 * dimension))
  {
    RefuseShape(file, name("means"),
      "[" + std::to_string(rows) + ", " + std::to_string(2 * dimension) + " or " + std::to_string(3 * dimension) + "]");
  }
  if (file.Contains(name("labels")))
  {
    file.RequireIntegers(name("labels"));
    if (file.Entry(name("labels")).Shape != std::vector<std::int64_t>{ rows })
    {
      RefuseShape(file, name("labels"), "[" + std::to_string(rows) + "]");
    }
  }
  if (file.Contains(name("directions")))
  {
    const auto [directions, components] = RequireLatentTable(file, name("directions"), true);
    if (directions != rows || (components != 2 && components != 3))
    {
      RefuseShape(file, name("directions"), "[" + std::to_string(rows) + ", 2 or 3]");
    }
  }
}

LatentColumns ReadColumns(const SafetensorsFile& file, const std::string& name)
{
  const std::vector<float> values = file.Float32(name);
  const std::vector<std::int64_t>& shape = file.Entry(name).Shape;
  return Eigen::Map<const LatentColumns>(values.data(), shape[0], shape[1]);
}

TriangleMesh ReadSurfaceMesh(const SafetensorsFile& file, std::size_t surface)
{
  const std::vector<double> points = file.Float64(SurfaceTensor(surface, "points"));
  const std::vector<std::int64_t> ids = file.Integers(SurfaceTensor(surface, "triangles"));
  TriangleMesh mesh;
  mesh.Points = Eigen::Map<const PointMatrix>(points.data(), static_cast<Eigen::Index>(points.size() / 3), 3);
  mesh.Triangles.resize(static_cast<Eigen::Index>(ids.size() / 3), 3);
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    // A number that is no vertex id in any mesh becomes one that is out of range.
    mesh.Triangles.data()[k] = ids[k] < 0 || ids[k] > std::numeric_limits<Index>::max() ? Index(-1)
                                                                                        : static_cast<Index>(ids[k]);
  }
  return mesh;
}

/// Tangent parts of vectors in world axes, [V, 3 n] to [V, 2 n].
LatentColumns TangentParts(const VertexFrames& frames, const LatentColumns& vectors)
{
  LatentColumns parts(vectors.rows(), vectors.cols() / 3 * 2);
  for (Eigen::Index v = 0; v < vectors.rows(); ++v)
  {
    for (Eigen::Index j = 0; j < vectors.cols() / 3; ++j)
    {
      const Eigen::RowVector3d vector = vectors.block<1, 3>(v, 3 * j).cast<double>();
      parts(v, 2 * j) = static_cast<float>(vector.dot(frames.X.row(v)));
      parts(v, 2 * j + 1) = static_cast<float>(vector.dot(frames.Y.row(v)));
    }
  }
  return parts;
}

LatentSurface ReadSurface(const SafetensorsFile& file, std::size_t number)
{
  const auto name = [number](const char* part) { return SurfaceTensor(number, part); };
  LatentSurface surface;
  surface.Mesh = ReadSurfaceMesh(file, number);
  surface.Means = ReadColumns(file, name("means"));
  surface.Deviations = ReadColumns(file, name("deviations"));
  if (file.Contains(name("labels")))
  {
    for (const std::int64_t label : file.Integers(name("labels")))
    {
      // A number that is no label becomes one that is out of range.
      surface.Labels.push_back(label < -1 || label > LargestLabel ? -2 : static_cast<std::int32_t>(label));
    }
  }
  if (file.Contains(name("directions")))
  {
    surface.Directions = ReadColumns(file, name("directions"));
  }
  const bool worldMeans = surface.Means.cols() == 3 * surface.Deviations.cols();
  const bool worldDirections = surface.Directions.cols() == 3;
  if (worldMeans || worldDirections)
  {
    const VertexFrames frames = TangentFrames(surface.Mesh, RequireValidMesh(surface.Mesh));
    surface.Means = worldMeans ? TangentParts(frames, surface.Means) : surface.Means;
    surface.Directions = worldDirections ? TangentParts(frames, surface.Directions) : surface.Directions;
  }
  return surface;
}

[[noreturn]] void RefuseLatents(const std::string& found, const std::string& expected)
{
  throw InvalidInput("CheckDataset: " + found + "; expected " + expected + ".");
}

/// Checks one table of a surface. Without columns there are no rows.
void CheckColumns(const LatentColumns& table, Eigen::Index rows, Eigen::Index columns, const std::string& name)
{
  if (table.rows() != (columns == 0 ? 0 : rows) || table.cols() != columns)
  {
    RefuseLatents(name + " are [" + std::to_string(table.rows()) + ", " + std::to_string(table.cols()) + "]",
      columns == 0 ? "none, as in surface 0" : "[" + std::to_string(rows) + ", " + std::to_string(columns) + "]");
  }
  if (!table.allFinite())
  {
    RefuseLatents(name + " are not finite", "finite numbers");
  }
}

void CheckSurface(const LatentSurface& surface, const LatentSurface& first, std::size_t number)
{
  const std::string of = " of surface " + std::to_string(number);
  const Eigen::Index rows = surface.Mesh.Points.rows();
  const Eigen::Index dimension = first.Deviations.cols();
  if (rows == 0 || dimension == 0)
  {
    RefuseLatents("the latents" + of + " have no vertex or no tangent vector", "at least one of each");
  }
  CheckColumns(surface.Means, rows, 2 * dimension, "the means" + of);
  CheckColumns(surface.Deviations, rows, dimension, "the deviations" + of);
  CheckColumns(surface.Directions, rows, first.Directions.size() > 0 ? 2 : 0, "the directions" + of);
  if ((surface.Deviations.array() < 0.0F).any())
  {
    RefuseLatents("a deviation" + of + " is negative", "0 or more");
  }
  const std::size_t labels = first.Labels.empty() ? 0 : static_cast<std::size_t>(rows);
  if (surface.Labels.size() != labels)
  {
    RefuseLatents("there are " + std::to_string(surface.Labels.size()) + " labels" + of,
      labels == 0 ? "none, as in surface 0" : std::to_string(labels));
  }
  for (const std::int32_t label : surface.Labels)
  {
    if (label < -1 || label > LargestLabel)
    {
      RefuseLatents("a label" + of + " is out of range", "-1 (none) to " + std::to_string(LargestLabel));
    }
  }
}

/// FNV-1a of the bytes of an array.
template <typename Array>
void AddArrayToHash(const Array& array, std::uint64_t& hash)
{
  const auto* bytes = reinterpret_cast<const unsigned char*>(array.data());
  const std::size_t size = static_cast<std::size_t>(array.size()) * sizeof(*array.data());
  for (std::size_t k = 0; k < size; ++k)
  {
    hash = (hash ^ bytes[k]) * 0x100000001b3;
  }
}

TensorData ColumnTensor(const LatentColumns& table)
{
  return TensorData::FromFloat32(
    { table.rows(), table.cols() }, std::vector<float>(table.data(), table.data() + table.size()));
}
} // namespace

std::int64_t LatentDataset::Dimension() const
{
  return this->Surfaces.empty() ? 0 : this->Surfaces.front().Deviations.cols();
}

std::int64_t LatentDataset::NumberOfLabels() const
{
  std::int32_t largest = -1;
  for (const LatentSurface& surface : this->Surfaces)
  {
    for (const std::int32_t label : surface.Labels)
    {
      largest = std::max(largest, label);
    }
  }
  return largest + 1;
}

bool LatentDataset::IsDirected() const
{
  return !this->Surfaces.empty() && this->Surfaces.front().Directions.size() > 0;
}

void CheckDataset(const LatentDataset& dataset)
{
  if (dataset.Surfaces.empty())
  {
    RefuseLatents("the dataset has no surface", "at least one");
  }
  for (std::size_t k = 0; k < dataset.Surfaces.size(); ++k)
  {
    CheckSurface(dataset.Surfaces[k], dataset.Surfaces.front(), k);
  }
}

std::uint64_t ContentHash(const LatentDataset& dataset)
{
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const LatentSurface& surface : dataset.Surfaces)
  {
    AddArrayToHash(surface.Mesh.Points, hash);
    AddArrayToHash(surface.Mesh.Triangles, hash);
    AddArrayToHash(surface.Means, hash);
    AddArrayToHash(surface.Deviations, hash);
    AddArrayToHash(surface.Labels, hash);
    AddArrayToHash(surface.Directions, hash);
  }
  return hash;
}

LatentDataset ReadLatentDataset(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireMetadata(file, "content", LatentContent, LatentKind);
  RequireMetadata(file, "format_version", DatasetFormatVersion, LatentKind);
  std::size_t surfaces = 0;
  for (; surfaces == 0 || file.Contains(SurfaceTensor(surfaces, "points")); ++surfaces)
  {
    RequireSurface(file, surfaces);
  }
  RequireNumbers(file, "surfaces", surfaces);
  file.RequireMemory(CopiesInMemory);
  LatentDataset dataset;
  const auto autoencoder = file.Metadata().find("autoencoder");
  dataset.Autoencoder = autoencoder == file.Metadata().end() ? "" : autoencoder->second;
  try
  {
    for (std::size_t k = 0; k < surfaces; ++k)
    {
      dataset.Surfaces.push_back(ReadSurface(file, k));
    }
    CheckDataset(dataset);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  return dataset;
}

void WriteLatentDataset(const std::string& path, const LatentDataset& dataset)
{
  CheckDataset(dataset);
  std::map<std::string, TensorData> tensors;
  for (std::size_t k = 0; k < dataset.Surfaces.size(); ++k)
  {
    const LatentSurface& surface = dataset.Surfaces[k];
    const TriangleMesh& mesh = surface.Mesh;
    tensors[SurfaceTensor(k, "points")] = TensorData::FromFloat64(
      { mesh.Points.rows(), 3 }, std::vector<double>(mesh.Points.data(), mesh.Points.data() + mesh.Points.size()));
    tensors[SurfaceTensor(k, "triangles")] = TensorData::FromInt64({ mesh.Triangles.rows(), 3 },
      std::vector<std::int64_t>(mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size()));
    tensors[SurfaceTensor(k, "means")] = ColumnTensor(surface.Means);
    tensors[SurfaceTensor(k, "deviations")] = ColumnTensor(surface.Deviations);
    if (!surface.Labels.empty())
    {
      tensors[SurfaceTensor(k, "labels")] = TensorData::FromInt64({ static_cast<std::int64_t>(surface.Labels.size()) },
        std::vector<std::int64_t>(surface.Labels.begin(), surface.Labels.end()));
    }
    if (surface.Directions.size() > 0)
    {
      tensors[SurfaceTensor(k, "directions")] = ColumnTensor(surface.Directions);
    }
  }
  std::map<std::string, std::string> metadata = { { "content", LatentContent },
    { "format_version", DatasetFormatVersion }, { "producer", "SurfaceSynthesis" } };
  if (!dataset.Autoencoder.empty())
  {
    metadata["autoencoder"] = dataset.Autoencoder;
  }
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
