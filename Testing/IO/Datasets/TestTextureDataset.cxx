// SPDX-License-Identifier: BSD-3-Clause
// Datasets of images and planar meshes: files, and what is refused.
#include "SmallTextures.h"
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

using namespace surfsynth;
using testing::AllOf;
using testing::HasSubstr;

namespace
{
using Tensors = std::map<std::string, TensorData>;
using Metadata = std::map<std::string, std::string>;

constexpr const char* Path = "textures.safetensors";

/// What reading a file of one image and one mesh says after @p change.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  Tensors tensors = { { "images.0", { TensorType::UInt8, { 1, 2, 3 }, { 0, 1, 2, 3, 4, 5 } } },
    { "meshes.0.points", TensorData::FromFloat32({ 5, 2 }, { 0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0.5 }) },
    { "meshes.0.triangles", TensorData::FromInt64({ 4, 3 }, { 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4 }) } };
  Metadata metadata = { { "content", "textures" }, { "format_version", "1" } };
  change(tensors, metadata);
  WriteSafetensors(Path, tensors, metadata);
  std::string text = "accepted";
  try
  {
    ReadTextureDataset(Path);
  }
  catch (const ModelMismatch& error)
  {
    text = error.what();
  }
  std::remove(Path);
  return text;
}

std::string RefusalOf(const std::function<void(TextureDataset&)>& change)
{
  TextureDataset dataset = test::SmallTextures();
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

TEST(TextureDataset, FilesHoldImagesAndMeshes)
{
  const TextureDataset dataset = test::SmallTextures();
  WriteTextureDataset(Path, dataset);
  const TextureDataset read = ReadTextureDataset(Path);
  std::remove(Path);
  ASSERT_EQ(read.Images.size(), 2U);
  ASSERT_EQ(read.Meshes.size(), 2U);
  EXPECT_EQ(read.Images[1].Height, 64);
  EXPECT_EQ(read.Images[1].Width, 50);
  EXPECT_EQ(read.Images[1].Pixels, dataset.Images[1].Pixels);
  EXPECT_EQ(read.Meshes[0].Points, dataset.Meshes[0].Points);
  EXPECT_EQ(read.Meshes[0].Triangles, dataset.Meshes[0].Triangles);
  EXPECT_EQ(ContentHash(read), ContentHash(dataset));
  TextureDataset other = dataset;
  other.Images[0].Pixels[5] ^= 1;
  EXPECT_NE(ContentHash(other), ContentHash(dataset));
}

TEST(TextureDataset, InteriorVerticesAreThoseInsideTheSquare)
{
  const PlanarMesh mesh = test::SquareMesh(6);
  EXPECT_EQ(InteriorVertices(mesh).size(), 25U);
  for (const Index v : InteriorVertices(mesh))
  {
    EXPECT_GT(mesh.Points.row(v).minCoeff(), 0.01);
    EXPECT_LT(mesh.Points.row(v).maxCoeff(), 0.99);
  }
}

TEST(TextureDataset, FilesThatDoNotFitAreNamed)
{
  EXPECT_EQ(MessageAfter([](Tensors&, Metadata&) {}), "accepted");
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["content"] = "surface_signals"; }),
    AllOf(HasSubstr("\"content\" is \"surface_signals\""), HasSubstr("expected \"textures\"")));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["format_version"] = "2"; }),
    HasSubstr("\"format_version\" is \"2\""));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("images.0"); }), HasSubstr("images.0"));
  EXPECT_THAT(
    MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("meshes.0.points"); }), HasSubstr("meshes.0.points"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["images.0"] = { TensorType::UInt8, { 2, 3 }, { 0, 1, 2, 3, 4, 5 } };
  }),
    HasSubstr("\"images.0\" is [2, 3] of type U8; expected [height, width, 3] of type U8"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["images.0"] = TensorData::FromFloat32({ 1, 1, 3 }, { 0, 1, 0 });
  }),
    HasSubstr("of type F32"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["meshes.0.points"] = TensorData::FromFloat32({ 2, 3 }, { 0, 0, 0, 0, 0, 0 });
  }),
    HasSubstr("\"meshes.0.points\" is [2, 3]; expected [rows, 2]"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["meshes.0.triangles"] = TensorData::FromInt64({ 1, 3 }, { 0, 1, std::int64_t(1) << 40 });
  }),
    HasSubstr("triangle 0 of mesh 0 has vertices that do not exist"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors["images.2"] = tensors["images.0"]; }),
    AllOf(HasSubstr("a tensor \"images.2\""), HasSubstr("\"images.1\" is missing")));
  EXPECT_THAT(
    MessageAfter([](Tensors& tensors, Metadata&) { tensors["meshes.01.points"] = tensors["meshes.0.points"]; }),
    AllOf(HasSubstr("\"meshes.01.points\""), HasSubstr("\"meshes.1\" is missing")));
  EXPECT_THROW(ReadTextureDataset("absent.safetensors"), InvalidInput);
}

TEST(TextureDataset, PartsThatDoNotFitAreNamed)
{
  EXPECT_EQ(RefusalOf([](TextureDataset&) {}), "accepted");
  EXPECT_THAT(RefusalOf([](TextureDataset& dataset) { dataset.Images.clear(); }), HasSubstr("0 images and 2 meshes"));
  EXPECT_THAT(RefusalOf([](TextureDataset& dataset) { dataset.Images[1].Pixels.pop_back(); }),
    HasSubstr("image 1 has 9599 bytes for a height of 64 and a width of 50"));
  EXPECT_THAT(RefusalOf([](TextureDataset& dataset) { dataset.Meshes[1].Points(3, 0) = 1.5; }),
    HasSubstr("mesh 1 has a point outside the unit square"));
  EXPECT_THAT(RefusalOf([](TextureDataset& dataset) { dataset.Meshes[0].Triangles.row(2).reverseInPlace(); }),
    HasSubstr("triangle 2 of mesh 0"));
  EXPECT_THAT(RefusalOf([](TextureDataset& dataset) { dataset.Meshes[0] = test::SquareMesh(1); }),
    HasSubstr("mesh 0 has no vertex that its triangles surround"));
}

TEST(TextureDataset, FilesAreJudgedByTheirHeaders)
{
  const Metadata metadata = { { "content", "textures" }, { "format_version", "1" } };
  test::SparseTensors tensors = { { "images.0", { "F32", { test::SparseBytes / 12, 1, 3 } } } };
  test::WriteSparseModel("sparse.safetensors", tensors, metadata);
  const std::uint64_t before = test::PeakMemory();
  EXPECT_THROW(ReadTextureDataset("sparse.safetensors"), ModelMismatch);
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove("sparse.safetensors");
}
