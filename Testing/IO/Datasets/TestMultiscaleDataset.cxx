// SPDX-License-Identifier: BSD-3-Clause
// Datasets of one surface at several scales: files, and what is refused.
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{

MultiscaleDataset TwoLevels()
{
  TriangleMesh mesh;
  mesh.Points.resize(4, 3);
  mesh.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.Triangles.resize(4, 3);
  mesh.Triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  MultiscaleDataset dataset;
  dataset.Levels.push_back(mesh);
  dataset.Levels.push_back(SubdivideAtMidpoints(mesh).Mesh);
  dataset.Levels[1].Points(7, 2) += 0.125;
  dataset.Template = mesh;
  dataset.Template.Points *= 0.3;
  return dataset;
}

const std::map<std::string, std::string> Metadata = { { "content", "multiscale_surface" }, { "format_version", "1" } };

std::string RefusalOf(
  const std::map<std::string, TensorData>& tensors, const std::map<std::string, std::string>& metadata)
{
  WriteSafetensors("multiscale.safetensors", tensors, metadata);
  std::string text;
  try
  {
    ReadMultiscaleDataset("multiscale.safetensors");
  }
  catch (const ModelMismatch& error)
  {
    text = error.what();
  }
  std::remove("multiscale.safetensors");
  return text;
}

std::map<std::string, TensorData> OneTriangle(std::int64_t lastId)
{
  return { { "levels.0.points", TensorData::FromFloat32({ 3, 3 }, { 0, 0, 0, 1, 0, 0, 0, 1, 0 }) },
    { "levels.0.triangles", TensorData::FromInt64({ 1, 3 }, { 0, 1, lastId }) } };
}

} // namespace

TEST(MultiscaleDataset, FilesHoldAllLevelsAndTheTemplate)
{
  MultiscaleDataset dataset = TwoLevels();
  for (const bool withTemplate : { true, false })
  {
    dataset.Template = withTemplate ? dataset.Template : TriangleMesh();
    WriteMultiscaleDataset("levels.safetensors", dataset);
    const MultiscaleDataset found = ReadMultiscaleDataset("levels.safetensors");
    ASSERT_EQ(found.Levels.size(), 2U);
    EXPECT_EQ(found.Levels[1].Points, dataset.Levels[1].Points);
    EXPECT_EQ(found.Levels[1].Triangles, dataset.Levels[1].Triangles);
    EXPECT_EQ(found.HasTemplate(), withTemplate);
    EXPECT_EQ(ContentHash(found), ContentHash(dataset));
  }
  std::remove("levels.safetensors");
}

TEST(MultiscaleDataset, MeanEdgeLengthCountsEachEdgeOnce)
{
  EXPECT_NEAR(MeanEdgeLength(TwoLevels().Levels[0]), (3.0 + 3.0 * std::sqrt(2.0)) / 6.0, 1e-14);
  EXPECT_EQ(MeanEdgeLength(TriangleMesh()), 0.0);
}

TEST(MultiscaleDataset, FilesOfAnotherKindAreRefused)
{
  EXPECT_EQ(RefusalOf(OneTriangle(2), Metadata), "");
  EXPECT_THAT(RefusalOf(OneTriangle(2), { { "format_version", "1" } }), HasSubstr("\"content\" is missing"));
  EXPECT_THAT(RefusalOf(OneTriangle(3), Metadata), HasSubstr("names vertex 3; expected ids from 0 to 2"));
  EXPECT_THAT(RefusalOf(OneTriangle(-1), Metadata), HasSubstr("names vertex -1"));
  EXPECT_THAT(RefusalOf({}, Metadata), HasSubstr("levels.0.points"));
  auto flat = OneTriangle(2);
  flat["levels.0.points"] = TensorData::FromFloat32({ 9 }, { 0, 0, 0, 1, 0, 0, 0, 1, 0 });
  EXPECT_THAT(RefusalOf(flat, Metadata), HasSubstr("no table of three columns"));
  auto unrelated = OneTriangle(2);
  unrelated["levels.1.points"] = unrelated["levels.0.points"];
  unrelated["levels.1.triangles"] = unrelated["levels.0.triangles"];
  EXPECT_THAT(RefusalOf(unrelated, Metadata), HasSubstr("level 1 has other triangles"));
  EXPECT_THROW(ReadMultiscaleDataset("absent.safetensors"), InvalidInput);
}

TEST(MultiscaleDataset, WhatIsNotFiniteIsNotWritten)
{
  MultiscaleDataset dataset = TwoLevels();
  dataset.Template.Points(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(WriteMultiscaleDataset("levels.safetensors", dataset), InvalidInput);
  EXPECT_THROW(WriteMultiscaleDataset("levels.safetensors", MultiscaleDataset()), InvalidInput);
}

TEST(MultiscaleDataset, FilesAreJudgedByTheirHeaders)
{
  const char* path = "sparse.multiscale";
  const std::int64_t rows = test::SparseBytes / 24;
  const auto refusal = [&](const test::SparseTensors& tensors) {
    test::WriteSparseModel(path, tensors, Metadata);
    try
    {
      ReadMultiscaleDataset(path);
    }
    catch (const std::exception& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  test::SparseTensors tensors = { { "levels.0.points", { "F64", { rows, 3 } } },
    { "levels.0.triangles", { "I64", { 1, 3 } } } };
  const std::uint64_t before = test::PeakMemory();
  test::SparseTensors other = tensors;
  other["levels.0.triangles"] = { "F64", { 1, 3 } };
  EXPECT_THAT(refusal(other), HasSubstr("is of type F64; expected I64"));
  other = tensors;
  other["levels.1.points"] = { "F64", { 9, 3 } };
  other["levels.1.triangles"] = { "I64", { 5, 3 } };
  EXPECT_THAT(refusal(other), HasSubstr("level 1 has other triangles than level 0 subdivided at midpoints: 5"));
  other = tensors;
  other["template.points"] = { "F64", { 9 } };
  EXPECT_THAT(refusal(other), HasSubstr("\"template.points\" is no table of three columns"));
  tensors["levels.0.points"] = { "F64", { 2000000000, 3 } };
  tensors["levels.0.triangles"] = { "I64", { 2000000000, 3 } };
  tensors["template.points"] = { "F64", { 2000000000, 3 } };
  tensors["unknown"] = { "F64", { 2000000000, 100 } };
  EXPECT_THAT(refusal(tensors), HasSubstr("GB of memory; expected at most the"));
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove(path);
}
