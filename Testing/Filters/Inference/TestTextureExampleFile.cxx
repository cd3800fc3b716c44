// SPDX-License-Identifier: BSD-3-Clause
// Example files of geometric textures: what is written is read, and what does not fit is named.
#include "ExampleMeshes.h"
#include "ModelFileChecks.h"

#include "IO/Weights/InstalledModels.h"
#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/GeometricTexture/TextureExampleFile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynth;
using testing::AllOf;
using testing::HasSubstr;

namespace
{
using test::Metadata;
using test::Tensors;

constexpr const char* Path = "TextureExampleFile.safetensors";
constexpr const char* Key = "geometric_texture_example";

TensorData Rows(const PointMatrix& rows)
{
  return TensorData::FromFloat64({ rows.rows(), 3 }, std::vector<double>(rows.data(), rows.data() + rows.size()));
}

TensorData Triangles(const TriangleMatrix& triangles)
{
  return TensorData::FromInt64(
    { triangles.rows(), 3 }, std::vector<std::int64_t>(triangles.data(), triangles.data() + triangles.size()));
}

TriangleMesh Ball() { return test::Icosphere(1); }

void WriteExample(const std::string& path)
{
  const TriangleMesh ball = Ball();
  WriteSafetensors(path, { { "points", Rows(ball.Points) }, { "triangles", Triangles(ball.Triangles) } },
    { { "architecture", Key }, { "format_version", "1" }, { Key, R"({"name": "ball", "smoothing_length": 0.25})" } });
}

const test::ModelFileKind Kind{ Path, Key, WriteExample, [](const std::string& path) { ReadTextureExample(path); } };

std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  return test::MessageAfter(Kind, change);
}
} // namespace

TEST(TextureExampleFile, IsReadAsItWasWritten)
{
  WriteExample(Path);
  const TextureExampleFile example = ReadTextureExample(Path);
  EXPECT_EQ(example.Name, "ball");
  EXPECT_EQ(example.SmoothingLength, 0.25);
  EXPECT_EQ(example.Textured.Points, Ball().Points);
  EXPECT_EQ(example.Textured.Triangles, Ball().Triangles);
  EXPECT_EQ(example.PlainPoints.rows(), 0);
  EXPECT_EQ(example.Directions.rows(), 0);
}

TEST(TextureExampleFile, MayHoldThePlainExampleAndDirections)
{
  const PointMatrix plain = 0.9 * Ball().Points;
  const PointMatrix directions = PointMatrix::Ones(plain.rows(), 3);
  const auto add = [&](Tensors& tensors, Metadata& metadata) {
    tensors["plain_points"] = Rows(plain);
    tensors["directions"] = Rows(directions);
    metadata[Key] = R"({"name": "ball"})"; // no smoothing
  };
  ASSERT_EQ(MessageAfter(add), "accepted");
  const TextureExampleFile example = ReadTextureExample(Path);
  EXPECT_EQ(example.PlainPoints, plain);
  EXPECT_EQ(example.Directions, directions);
  EXPECT_EQ(example.SmoothingLength, 0.0);
}

TEST(TextureExampleFile, MetadataAreChecked)
{
  test::ExpectMetadataAreChecked(Kind);
  test::ExpectKeysAreNeeded(Kind, { "name", "smoothing_length" });
  for (const char* length : { "0.0", "-1.0", "\"wide\"" })
  {
    EXPECT_THAT(test::MessageWith(Kind, "0.25", length), HasSubstr("\"smoothing_length\"")) << length;
  }
}

TEST(TextureExampleFile, TensorsAreChecked)
{
  const auto messageWith = [](const std::string& name, const TensorData& tensor) {
    return MessageAfter([&](Tensors& tensors, Metadata&) { tensors[name] = tensor; });
  };
  const PointMatrix few = PointMatrix::Zero(3, 3);
  PointMatrix broken = Ball().Points;
  broken(4, 1) = std::numeric_limits<double>::quiet_NaN();
  TriangleMatrix beyond = Ball().Triangles;
  beyond(0, 0) = 1000;
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("triangles"); }),
    AllOf(HasSubstr("ModelMismatch"), HasSubstr("\"triangles\"")));
  EXPECT_THAT(messageWith("colors", Rows(few)), HasSubstr("\"colors\" does not belong to it"));
  EXPECT_THAT(messageWith("directions", Rows(few)), HasSubstr("\"directions\""));
  EXPECT_THAT(messageWith("plain_points", Rows(few)), HasSubstr("\"plain_points\""));
  EXPECT_THAT(messageWith("points", Rows(broken)), HasSubstr("FormatError"));
  EXPECT_THAT(messageWith("triangles", Triangles(beyond)), HasSubstr("the example is broken"));
  EXPECT_THAT(messageWith("triangles", Triangles(TriangleMatrix(0, 3))), HasSubstr("ModelMismatch"));
  EXPECT_THAT(messageWith("triangles", Rows(few)), HasSubstr("ModelMismatch"));
  EXPECT_THAT(messageWith("plain_points", Rows(PointMatrix::Zero(Ball().NumberOfPoints(), 3))),
    HasSubstr("the plain example is broken"));
}

TEST(TextureExampleFile, InstalledOnesAreWhatTheyAreSaidToBe)
{
  const TextureExampleFile cortex = ReadTextureExample(ModelPath("cortex"));
  EXPECT_GT(cortex.Textured.NumberOfTriangles(), 10000);
  EXPECT_EQ(cortex.Directions.rows(), 0);
  const TextureExampleFile mane = ReadTextureExample(ModelPath("mane"));
  EXPECT_EQ(mane.Directions.rows(), mane.Textured.NumberOfPoints());
  EXPECT_EQ(ReadTextureExample(ModelPath("mountains")).Name, "mountains");
}
