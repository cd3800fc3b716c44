// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/MultiscaleDataset.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "IO/Datasets/DatasetFiles.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <limits>

namespace surfsynth
{

namespace
{
constexpr const char* MultiscaleContent = "multiscale_surface";
constexpr const char* MultiscaleKind = "as in files of one surface at several scales";
constexpr const char* TemplatePoints = "template.points";

std::string LevelTensor(std::size_t level, const char* part) { return "levels." + std::to_string(level) + "." + part; }

/// Number of rows of a tensor that must be [rows, 3].
std::int64_t RequireRows(const SafetensorsFile& file, const std::string& name)
{
  const std::vector<std::int64_t>& shape = file.Entry(name).Shape;
  if (shape.size() != 2 || shape[1] != 3 || shape[0] > std::numeric_limits<Index>::max())
  {
    throw ModelMismatch(
      file.Name() + ": \"" + name + "\" is no table of three columns and fewer than 2^31 rows; expected one.");
  }
  return shape[0];
}

/// Checks shapes and types of the tensors of the levels and of the template, before they are read. Returns the number
/// of levels.
std::size_t RequireLevels(const SafetensorsFile& file)
{
  std::size_t level = 0;
  for (std::int64_t before = 0; level == 0 || file.Contains(LevelTensor(level, "points")); ++level)
  {
    const std::string triangles = LevelTensor(level, "triangles");
    RequireRows(file, LevelTensor(level, "points"));
    const std::int64_t rows = RequireRows(file, triangles);
    file.RequireFloatingPoint(LevelTensor(level, "points"));
    file.RequireIntegers(triangles);
    if (level > 0 && rows != 4 * before)
    {
      throw ModelMismatch(file.Name() + ": level " + std::to_string(level) + " has other triangles than level " +
        std::to_string(level - 1) + " subdivided at midpoints: " + std::to_string(rows) + "; expected " +
        std::to_string(4 * before) + ".");
    }
    before = rows;
  }
  if (file.Contains(TemplatePoints))
  {
    RequireRows(file, TemplatePoints);
    file.RequireFloatingPoint(TemplatePoints);
  }
  return level;
}

PointMatrix ReadPoints(const SafetensorsFile& file, const std::string& name)
{
  const std::int64_t rows = RequireRows(file, name);
  const std::vector<double> numbers = file.Float64(name);
  return Eigen::Map<const PointMatrix>(numbers.data(), rows, 3);
}

TriangleMesh ReadLevel(const SafetensorsFile& file, std::size_t level)
{
  TriangleMesh mesh;
  mesh.Points = ReadPoints(file, LevelTensor(level, "points"));
  const std::string name = LevelTensor(level, "triangles");
  mesh.Triangles.resize(RequireRows(file, name), 3);
  const std::vector<std::int64_t> ids = file.Integers(name);
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    if (ids[k] < 0 || ids[k] >= mesh.NumberOfPoints())
    {
      throw ModelMismatch(file.Name() + ": \"" + name + "\" names vertex " + std::to_string(ids[k]) +
        "; expected ids from 0 to " + std::to_string(mesh.NumberOfPoints() - 1) + ".");
    }
    mesh.Triangles.data()[k] = static_cast<Index>(ids[k]);
  }
  return mesh;
}

TensorData PointData(const PointMatrix& points)
{
  return TensorData::FromFloat64(
    { points.rows(), 3 }, std::vector<double>(points.data(), points.data() + points.size()));
}

bool SameTriangles(const TriangleMesh& a, const TriangleMesh& b)
{
  return a.Triangles.rows() == b.Triangles.rows() && a.Triangles == b.Triangles;
}

void RequireTriangles(const TriangleMesh& mesh, const std::string& what)
{
  if (mesh.NumberOfTriangles() == 0 || !mesh.Points.allFinite())
  {
    throw InvalidInput("CheckDataset: " + what + " has " + std::to_string(mesh.NumberOfTriangles()) +
      " triangles and " + std::to_string(mesh.NumberOfPoints()) + " points; expected triangles on finite points.");
  }
}
} // namespace

void CheckDataset(const MultiscaleDataset& dataset)
{
  if (dataset.Levels.empty())
  {
    throw InvalidInput("CheckDataset: the dataset has no level; expected at least one.");
  }
  for (std::size_t k = 0; k < dataset.Levels.size(); ++k)
  {
    const TriangleMesh& mesh = dataset.Levels[k];
    const std::string what = "level " + std::to_string(k);
    RequireTriangles(mesh, what);
    if (k == 0)
    {
      continue;
    }
    const TriangleMesh finer = SubdivideAtMidpoints(dataset.Levels[k - 1]).Mesh;
    if (finer.NumberOfPoints() != mesh.NumberOfPoints() || !SameTriangles(finer, mesh))
    {
      throw InvalidInput("CheckDataset: " + what + " has other triangles or another number of points than level " +
        std::to_string(k - 1) + " subdivided at midpoints; expected the same.");
    }
  }
  if (dataset.HasTemplate())
  {
    RequireTriangles(dataset.Template, "the template");
    if (dataset.Template.NumberOfPoints() != dataset.Levels[0].NumberOfPoints() ||
      !SameTriangles(dataset.Template, dataset.Levels[0]))
    {
      throw InvalidInput(
        "CheckDataset: the template has other triangles or another number of points than level 0; expected the same.");
    }
  }
}

double MeanEdgeLength(const TriangleMesh& mesh)
{
  const SubdividedMesh subdivided = SubdivideAtMidpoints(mesh);
  double sum = 0.0;
  for (const auto& [a, b] : subdivided.Parents)
  {
    sum += (mesh.Points.row(a) - mesh.Points.row(b)).norm();
  }
  return subdivided.Parents.empty() ? 0.0 : sum / static_cast<double>(subdivided.Parents.size());
}

std::uint64_t ContentHash(const MultiscaleDataset& dataset)
{
  std::uint64_t hash = ContentHash(dataset.Template);
  for (const TriangleMesh& mesh : dataset.Levels)
  {
    hash = (hash ^ ContentHash(mesh)) * 0x100000001b3;
  }
  return hash;
}

MultiscaleDataset ReadMultiscaleDataset(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireMetadata(file, "content", MultiscaleContent, MultiscaleKind);
  RequireMetadata(file, "format_version", DatasetFormatVersion, MultiscaleKind);
  MultiscaleDataset dataset;
  const std::size_t levels = RequireLevels(file);
  file.RequireMemory(CopiesInMemory);
  for (std::size_t k = 0; k < levels; ++k)
  {
    dataset.Levels.push_back(ReadLevel(file, k));
  }
  if (file.Contains(TemplatePoints))
  {
    dataset.Template.Points = ReadPoints(file, TemplatePoints);
    dataset.Template.Triangles = dataset.Levels.front().Triangles;
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

void WriteMultiscaleDataset(const std::string& path, const MultiscaleDataset& dataset)
{
  CheckDataset(dataset);
  std::map<std::string, TensorData> tensors;
  for (std::size_t k = 0; k < dataset.Levels.size(); ++k)
  {
    const TriangleMatrix& triangles = dataset.Levels[k].Triangles;
    tensors[LevelTensor(k, "points")] = PointData(dataset.Levels[k].Points);
    tensors[LevelTensor(k, "triangles")] = TensorData::FromInt64(
      { triangles.rows(), 3 }, std::vector<std::int64_t>(triangles.data(), triangles.data() + triangles.size()));
  }
  if (dataset.HasTemplate())
  {
    tensors[TemplatePoints] = PointData(dataset.Template.Points);
  }
  WriteSafetensors(path, tensors,
    { { "content", MultiscaleContent }, { "format_version", DatasetFormatVersion },
      { "producer", "SurfaceSynthesis" } });
}

} // namespace surfsynth
