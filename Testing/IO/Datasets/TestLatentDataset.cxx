// SPDX-License-Identifier: BSD-3-Clause
// Datasets of field latents: files, vectors in world axes, and what is refused.
#include "SmallLatents.h"
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Operators/SurfaceOperators.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{
using Tensors = std::map<std::string, TensorData>;
using Metadata = std::map<std::string, std::string>;

constexpr const char* Path = "latents.safetensors";

/// What reading a file of one tetrahedron says after @p change.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  Tensors tensors = { { "surfaces.0.points",
                        TensorData::FromFloat32({ 4, 3 }, { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 }) },
    { "surfaces.0.triangles", TensorData::FromInt64({ 4, 3 }, { 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3 }) },
    { "surfaces.0.means", TensorData::FromFloat32({ 4, 2 }, { 0, 1, 2, 3, 4, 5, 6, 7 }) },
    { "surfaces.0.deviations", TensorData::FromFloat32({ 4, 1 }, { 1, 1, 1, 1 }) },
    { "surfaces.0.labels", TensorData::FromInt64({ 4 }, { -1, 0, 1, 1 }) } };
  Metadata metadata = { { "content", "field_latents" }, { "format_version", "1" } };
  change(tensors, metadata);
  WriteSafetensors(Path, tensors, metadata);
  std::string text = "accepted";
  try
  {
    ReadLatentDataset(Path);
  }
  catch (const ModelMismatch& error)
  {
    text = error.what();
  }
  std::remove(Path);
  return text;
}

std::string RefusalOf(const std::function<void(LatentDataset&)>& change)
{
  LatentDataset dataset = test::SmallLatents();
  change(dataset);
  try
  {
    CheckDataset(dataset);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "accepted";
}
} // namespace

TEST(LatentDataset, FilesHoldSurfacesAndLatents)
{
  LatentDataset dataset = test::SmallLatents();
  dataset.Autoencoder = "0123456789abcdef";
  WriteLatentDataset(Path, dataset);
  const LatentDataset read = ReadLatentDataset(Path);
  std::remove(Path);
  EXPECT_EQ(read.Autoencoder, "0123456789abcdef");
  ASSERT_EQ(read.Surfaces.size(), 2U);
  EXPECT_EQ(read.Dimension(), 2);
  EXPECT_EQ(read.NumberOfLabels(), 3);
  EXPECT_TRUE(read.IsDirected());
  EXPECT_EQ(read.Surfaces[1].Mesh.Points, dataset.Surfaces[1].Mesh.Points);
  EXPECT_EQ(read.Surfaces[1].Mesh.Triangles, dataset.Surfaces[1].Mesh.Triangles);
  EXPECT_EQ(read.Surfaces[1].Means, dataset.Surfaces[1].Means);
  EXPECT_EQ(read.Surfaces[1].Deviations, dataset.Surfaces[1].Deviations);
  EXPECT_EQ(read.Surfaces[1].Labels, dataset.Surfaces[1].Labels);
  EXPECT_EQ(read.Surfaces[1].Directions, dataset.Surfaces[1].Directions);
  EXPECT_EQ(ContentHash(read), ContentHash(dataset));
  for (LatentSurface& surface : dataset.Surfaces)
  {
    surface.Labels.clear();
    surface.Directions.resize(0, 0);
  }
  EXPECT_NE(ContentHash(read), ContentHash(dataset));
  WriteLatentDataset(Path, dataset);
  const LatentDataset plain = ReadLatentDataset(Path);
  std::remove(Path);
  EXPECT_EQ(plain.NumberOfLabels(), 0);
  EXPECT_FALSE(plain.IsDirected());
}

TEST(LatentDataset, VectorsInWorldAxesAreTakenToTheFrames)
{
  const LatentSurface surface = test::SmallLatents().Surfaces[0];
  const VertexFrames frames = TangentFrames(surface.Mesh, MeshTopology(surface.Mesh));
  std::vector<float> means;
  std::vector<float> directions;
  const auto add = [&](float a, float b, Index v, std::vector<float>& to) {
    // The part along the normal is left out.
    const Eigen::RowVector3d vector = static_cast<double>(a) * frames.X.row(v) +
      static_cast<double>(b) * frames.Y.row(v) + 0.7 * frames.Normal.row(v);
    to.insert(
      to.end(), { static_cast<float>(vector.x()), static_cast<float>(vector.y()), static_cast<float>(vector.z()) });
  };
  for (Index v = 0; v < surface.Mesh.NumberOfPoints(); ++v)
  {
    add(surface.Means(v, 0), surface.Means(v, 1), v, means);
    add(surface.Means(v, 2), surface.Means(v, 3), v, means);
    add(surface.Directions(v, 0), surface.Directions(v, 1), v, directions);
  }
  const TriangleMesh& mesh = surface.Mesh;
  const std::int64_t rows = mesh.NumberOfPoints();
  WriteSafetensors(Path,
    { { "surfaces.0.points",
        TensorData::FromFloat64({ rows, 3 }, { mesh.Points.data(), mesh.Points.data() + 3 * rows }) },
      { "surfaces.0.triangles",
        TensorData::FromInt64(
          { mesh.NumberOfTriangles(), 3 }, { mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size() }) },
      { "surfaces.0.means", TensorData::FromFloat32({ rows, 6 }, means) },
      { "surfaces.0.deviations", TensorData::FromFloat32({ rows, 2 }, std::vector<float>(2 * rows, 0.5F)) },
      { "surfaces.0.directions", TensorData::FromFloat32({ rows, 3 }, directions) } },
    { { "content", "field_latents" }, { "format_version", "1" } });
  const LatentSurface read = ReadLatentDataset(Path).Surfaces[0];
  std::remove(Path);
  EXPECT_LT((read.Means - surface.Means).cwiseAbs().maxCoeff(), 1e-5F);
  EXPECT_LT((read.Directions - surface.Directions).cwiseAbs().maxCoeff(), 1e-5F);
}

TEST(LatentDataset, FilesThatDoNotFitAreNamed)
{
  const auto after = [](const std::function<void(Tensors&)>& change) {
    return MessageAfter([&](Tensors& tensors, Metadata&) { change(tensors); });
  };
  const auto numbers = [](std::vector<std::int64_t> shape) {
    return TensorData::FromFloat32(shape, std::vector<float>(static_cast<std::size_t>(shape[0] * shape[1]), 1.0F));
  };
  EXPECT_EQ(MessageAfter([](Tensors&, Metadata&) {}), "accepted");
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["content"] = "textures"; }),
    HasSubstr("\"content\" is \"textures\""));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["format_version"] = "2"; }),
    HasSubstr("\"format_version\" is \"2\""));
  for (const char* part : { "points", "triangles", "means", "deviations" })
  {
    EXPECT_THAT(after([&](Tensors& tensors) { tensors.erase(std::string("surfaces.0.") + part); }), HasSubstr(part));
  }
  EXPECT_THAT(after([&](Tensors& tensors) {
    tensors["surfaces.0.points"] = numbers({ 4, 2 });
  }),
    HasSubstr("\"surfaces.0.points\" is [4, 2]; expected [vertices, 3]"));
  EXPECT_THAT(after([&](Tensors& tensors) {
    tensors["surfaces.0.deviations"] = numbers({ 3, 1 });
  }),
    HasSubstr("\"surfaces.0.deviations\" is [3, 1]; expected [4, d]"));
  EXPECT_THAT(after([&](Tensors& tensors) {
    tensors["surfaces.0.means"] = numbers({ 4, 4 });
  }),
    HasSubstr("\"surfaces.0.means\" is [4, 4]; expected [4, 2 or 3]"));
  EXPECT_THAT(after([&](Tensors& tensors) {
    tensors["surfaces.0.directions"] = numbers({ 4, 1 });
  }),
    HasSubstr("\"surfaces.0.directions\" is [4, 1]; expected [4, 2 or 3]"));
  EXPECT_THAT(after([&](Tensors& tensors) { tensors["surfaces.0.labels"] = TensorData::FromInt64({ 1 }, { 0 }); }),
    HasSubstr("\"surfaces.0.labels\" is [1]; expected [4]"));
  EXPECT_THAT(after([&](Tensors& tensors) {
    tensors["surfaces.0.labels"] = TensorData::FromInt64({ 4 }, { 0, 0, 0, std::int64_t(1) << 40 });
  }),
    HasSubstr("a label of surface 0 is out of range; expected -1 (none) to 65535"));
  EXPECT_THROW(ReadLatentDataset("absent.safetensors"), InvalidInput);
}

TEST(LatentDataset, PartsThatDoNotFitAreNamed)
{
  EXPECT_EQ(RefusalOf([](LatentDataset&) {}), "accepted");
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces.clear(); }), HasSubstr("no surface"));
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces[1].Means(3, 1) = std::nanf(""); }),
    HasSubstr("the means of surface 1 are not finite"));
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces[1].Deviations(3, 1) = -1.0F; }),
    HasSubstr("a deviation of surface 1 is negative"));
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces[1].Deviations.resize(42, 3); }),
    HasSubstr("the deviations of surface 1 are ["));
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces[0].Labels.clear(); }),
    HasSubstr("labels of surface 1; expected none, as in surface 0"));
  EXPECT_THAT(RefusalOf([](LatentDataset& dataset) { dataset.Surfaces[1].Directions.resize(0, 0); }),
    HasSubstr("the directions of surface 1 are [0, 0]"));
}

TEST(LatentDataset, FilesAreJudgedByTheirHeaders)
{
  test::SparseTensors tensors = { { "surfaces.0.points", { "F32", { test::SparseBytes / 16, 4 } } } };
  test::WriteSparseModel("sparse.safetensors", tensors, { { "content", "field_latents" }, { "format_version", "1" } });
  const std::uint64_t before = test::PeakMemory();
  EXPECT_THROW(ReadLatentDataset("sparse.safetensors"), ModelMismatch);
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove("sparse.safetensors");
}
