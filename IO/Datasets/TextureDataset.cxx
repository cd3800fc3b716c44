// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/TextureDataset.h"

#include "Core/Common/Errors.h"
#include "IO/Datasets/DatasetFiles.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace surfsynth
{

namespace
{
constexpr const char* TextureContent = "textures";
constexpr const char* TextureKind = "as in the dataset files of images and planar meshes";
constexpr std::int64_t ImageChannels = 3;
constexpr double FullTurn = 6.28318530717958647693;
constexpr double AngleTolerance = 1e-6;

std::string ImageName(std::size_t image) { return "images." + std::to_string(image); }

std::string MeshTensor(std::size_t mesh, const char* part) { return "meshes." + std::to_string(mesh) + "." + part; }

/// Checks that a tensor is a table of @p columns columns and fewer than 2^31 rows, without reading it.
void RequireTable(const SafetensorsFile& file, const std::string& name, std::int64_t columns)
{
  const std::vector<std::int64_t>& shape = file.Entry(name).Shape;
  if (shape.size() != 2 || shape[1] != columns || shape[0] > std::numeric_limits<Index>::max())
  {
    throw ModelMismatch(file.Name() + ": \"" + name + "\" is " + FormatShape(shape) + "; expected [rows, " +
      std::to_string(columns) + "] with fewer than 2^31 rows.");
  }
}

void RequireImage(const SafetensorsFile& file, const std::string& name)
{
  const TensorEntry& entry = file.Entry(name);
  if (entry.Type != TensorType::UInt8 || entry.Shape.size() != 3 || entry.Shape[2] != ImageChannels)
  {
    throw ModelMismatch(file.Name() + ": \"" + name + "\" is " + FormatShape(entry.Shape) + " of type " +
      std::string(TypeName(entry.Type)) + "; expected [height, width, 3] of type U8.");
  }
}

/// Checks shapes and types of all tensors, before they are read. Returns the numbers of images and meshes.
std::pair<std::size_t, std::size_t> RequireTextures(const SafetensorsFile& file)
{
  std::size_t images = 0;
  for (; images == 0 || file.Contains(ImageName(images)); ++images)
  {
    RequireImage(file, ImageName(images));
  }
  std::size_t meshes = 0;
  for (; meshes == 0 || file.Contains(MeshTensor(meshes, "points")); ++meshes)
  {
    RequireTable(file, MeshTensor(meshes, "points"), 2);
    RequireTable(file, MeshTensor(meshes, "triangles"), 3);
    file.RequireFloatingPoint(MeshTensor(meshes, "points"));
    file.RequireIntegers(MeshTensor(meshes, "triangles"));
  }
  RequireNumbers(file, "images", images);
  RequireNumbers(file, "meshes", meshes);
  return { images, meshes };
}

PlanarMesh ReadMesh(const SafetensorsFile& file, std::size_t number)
{
  const std::vector<double> points = file.Float64(MeshTensor(number, "points"));
  const std::vector<std::int64_t> ids = file.Integers(MeshTensor(number, "triangles"));
  PlanarMesh mesh;
  mesh.Points = Eigen::Map<const PlanarPoints>(points.data(), static_cast<Eigen::Index>(points.size() / 2), 2);
  mesh.Triangles.resize(static_cast<Eigen::Index>(ids.size() / 3), 3);
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    // A number that is no vertex id in any mesh becomes one that is out of range.
    mesh.Triangles.data()[k] = ids[k] < 0 || ids[k] > std::numeric_limits<Index>::max() ? Index(-1)
                                                                                        : static_cast<Index>(ids[k]);
  }
  return mesh;
}

[[noreturn]] void RefuseDataset(const std::string& found, const std::string& expected)
{
  throw InvalidInput("CheckDataset: " + found + "; expected " + expected + ".");
}

void CheckImage(const TextureImage& image, std::size_t number)
{
  const bool fits = image.Height >= 1 && image.Width >= 1 &&
    static_cast<std::int64_t>(image.Pixels.size()) == image.Height * image.Width * ImageChannels;
  if (!fits)
  {
    RefuseDataset("image " + std::to_string(number) + " has " + std::to_string(image.Pixels.size()) +
        " bytes for a height of " + std::to_string(image.Height) + " and a width of " + std::to_string(image.Width),
      "three for each of its pixels, of which there is at least one");
  }
}

/// Twice the signed area of a triangle.
double DoubleArea(const PlanarMesh& mesh, Eigen::Index triangle)
{
  const auto point = [&](Eigen::Index corner) { return mesh.Points.row(mesh.Triangles(triangle, corner)); };
  const Eigen::RowVector2d u = point(1) - point(0);
  const Eigen::RowVector2d v = point(2) - point(0);
  return u.x() * v.y() - u.y() * v.x();
}

void CheckPlanarMesh(const PlanarMesh& mesh, std::size_t number)
{
  const std::string name = "mesh " + std::to_string(number);
  const bool inside = mesh.Points.allFinite() && (mesh.Points.array() >= 0.0).all() &&
    (mesh.Points.array() <= 1.0).all();
  if (!inside || mesh.Points.rows() == 0)
  {
    RefuseDataset(name + " has a point outside the unit square, or none", "points with coordinates from 0 to 1");
  }
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    const auto corners = mesh.Triangles.row(f);
    if (corners.minCoeff() < 0 || corners.maxCoeff() >= mesh.Points.rows() || !(DoubleArea(mesh, f) > 0.0))
    {
      RefuseDataset(
        "triangle " + std::to_string(f) + " of " + name + " has vertices that do not exist or no positive area",
        "triangles that are counterclockwise");
    }
  }
  if (InteriorVertices(mesh).empty())
  {
    RefuseDataset(name + " has no vertex that its triangles surround", "at least one");
  }
}

/// FNV-1a.
void AddToHash(const void* data, std::size_t size, std::uint64_t& hash)
{
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t k = 0; k < size; ++k)
  {
    hash = (hash ^ bytes[k]) * 0x100000001b3;
  }
}
} // namespace

std::vector<Index> InteriorVertices(const PlanarMesh& mesh)
{
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(mesh.Points.rows());
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    for (Eigen::Index k = 0; k < 3; ++k)
    {
      const Index at = mesh.Triangles(f, k);
      const Eigen::RowVector2d u = mesh.Points.row(mesh.Triangles(f, (k + 1) % 3)) - mesh.Points.row(at);
      const Eigen::RowVector2d v = mesh.Points.row(mesh.Triangles(f, (k + 2) % 3)) - mesh.Points.row(at);
      angles[at] += std::atan2(std::abs(u.x() * v.y() - u.y() * v.x()), u.dot(v));
    }
  }
  std::vector<Index> interior;
  for (Eigen::Index v = 0; v < angles.size(); ++v)
  {
    if (std::abs(angles[v] - FullTurn) < AngleTolerance)
    {
      interior.push_back(static_cast<Index>(v));
    }
  }
  return interior;
}

void CheckDataset(const TextureDataset& dataset)
{
  if (dataset.Images.empty() || dataset.Meshes.empty())
  {
    RefuseDataset("the dataset has " + std::to_string(dataset.Images.size()) + " images and " +
        std::to_string(dataset.Meshes.size()) + " meshes",
      "at least one of each");
  }
  for (std::size_t k = 0; k < dataset.Images.size(); ++k)
  {
    CheckImage(dataset.Images[k], k);
  }
  for (std::size_t k = 0; k < dataset.Meshes.size(); ++k)
  {
    CheckPlanarMesh(dataset.Meshes[k], k);
  }
}

std::uint64_t ContentHash(const TextureDataset& dataset)
{
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const TextureImage& image : dataset.Images)
  {
    AddToHash(&image.Width, sizeof image.Width, hash);
    AddToHash(image.Pixels.data(), image.Pixels.size(), hash);
  }
  for (const PlanarMesh& mesh : dataset.Meshes)
  {
    AddToHash(mesh.Points.data(), sizeof(double) * static_cast<std::size_t>(mesh.Points.size()), hash);
    AddToHash(mesh.Triangles.data(), sizeof(Index) * static_cast<std::size_t>(mesh.Triangles.size()), hash);
  }
  return hash;
}

TextureDataset ReadTextureDataset(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireMetadata(file, "content", TextureContent, TextureKind);
  RequireMetadata(file, "format_version", DatasetFormatVersion, TextureKind);
  const auto [images, meshes] = RequireTextures(file);
  file.RequireMemory(CopiesInMemory);
  TextureDataset dataset;
  for (std::size_t k = 0; k < images; ++k)
  {
    const std::vector<std::int64_t>& shape = file.Entry(ImageName(k)).Shape;
    dataset.Images.push_back({ shape[0], shape[1], file.Bytes(ImageName(k)) });
  }
  for (std::size_t k = 0; k < meshes; ++k)
  {
    dataset.Meshes.push_back(ReadMesh(file, k));
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

void WriteTextureDataset(const std::string& path, const TextureDataset& dataset)
{
  CheckDataset(dataset);
  std::map<std::string, TensorData> tensors;
  for (std::size_t k = 0; k < dataset.Images.size(); ++k)
  {
    const TextureImage& image = dataset.Images[k];
    tensors[ImageName(k)] = { TensorType::UInt8, { image.Height, image.Width, ImageChannels }, image.Pixels };
  }
  for (std::size_t k = 0; k < dataset.Meshes.size(); ++k)
  {
    const PlanarMesh& mesh = dataset.Meshes[k];
    tensors[MeshTensor(k, "points")] = TensorData::FromFloat64(
      { mesh.Points.rows(), 2 }, std::vector<double>(mesh.Points.data(), mesh.Points.data() + mesh.Points.size()));
    tensors[MeshTensor(k, "triangles")] = TensorData::FromInt64({ mesh.Triangles.rows(), 3 },
      std::vector<std::int64_t>(mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size()));
  }
  WriteSafetensors(path, tensors,
    { { "content", TextureContent }, { "format_version", DatasetFormatVersion }, { "producer", "SurfaceSynthesis" } });
}

} // namespace surfsynth
