// SPDX-License-Identifier: BSD-3-Clause
// Dataset files: what is written is read, and each way to be wrong is refused in words.
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "IO/Datasets/SignalDataset.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{

SignalDataset TwoTriangles(int components)
{
  SignalDataset dataset;
  dataset.SignalName = "Heat";
  for (int k = 0; k < 2; ++k)
  {
    SignalSource source;
    source.Mesh.Points.resize(4 + k, 3);
    source.Mesh.Points.setRandom();
    source.Mesh.Triangles.resize(2, 3);
    source.Mesh.Triangles << 0, 1, 2, 0, 2, 3;
    source.Samples.resize(3 - k, (4 + k) * components);
    source.Samples.setRandom();
    dataset.Sources.push_back(source);
  }
  return dataset;
}

/// The content of a dataset file of one surface, to be spoilt.
struct FileContent
{
  std::map<std::string, TensorData> Tensors = { { "sources.0.points",
                                                  TensorData::FromFloat64({ 3, 3 }, { 0, 0, 0, 1, 0, 0, 0, 1, 0 }) },
    { "sources.0.triangles", TensorData::FromInt64({ 1, 3 }, { 0, 1, 2 }) },
    { "sources.0.signals", TensorData::FromFloat32({ 2, 3, 1 }, { 1, 2, 3, 4, 5, 6 }) } };
  std::map<std::string, std::string> Metadata = { { "content", "surface_signals" }, { "format_version", "1" },
    { "signal_name", "Heat" } };
};

void ExpectRefusal(const std::function<void(FileContent&)>& spoil, const std::string& words)
{
  FileContent content;
  spoil(content);
  WriteSafetensors("spoilt.dataset", content.Tensors, content.Metadata);
  try
  {
    ReadSignalDataset("spoilt.dataset");
    FAIL() << "accepted; expected \"" << words << "\"";
  }
  catch (const ModelMismatch& error)
  {
    EXPECT_THAT(error.what(), HasSubstr("spoilt.dataset"));
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

TEST(SignalDataset, IsReadAsItWasWritten)
{
  for (const int components : { 1, 3 })
  {
    const SignalDataset written = TwoTriangles(components);
    WriteSignalDataset("two.dataset", written);
    const SignalDataset read = ReadSignalDataset("two.dataset");
    EXPECT_EQ(read.SignalName, "Heat");
    EXPECT_FALSE(read.HoldsPositions());
    EXPECT_EQ(read.NumberOfComponents(), components);
    EXPECT_EQ(read.NumberOfSamples(), 5);
    ASSERT_EQ(read.Sources.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k)
    {
      EXPECT_EQ(read.Sources[k].Mesh.Points, written.Sources[k].Mesh.Points);
      EXPECT_EQ(read.Sources[k].Mesh.Triangles, written.Sources[k].Mesh.Triangles);
      EXPECT_EQ(read.Sources[k].Samples, written.Sources[k].Samples);
    }
  }
}

TEST(SignalDataset, KeepsWhereItComesFromAndItsLicense)
{
  SignalDataset dataset = TwoTriangles(3);
  WriteSignalDataset("plain.dataset", dataset);
  EXPECT_EQ(ReadSignalDataset("plain.dataset").Origin + ReadSignalDataset("plain.dataset").License, "");
  dataset.Origin = "a package";
  dataset.License = "a license; as its owner states it";
  WriteSignalDataset("named.dataset", dataset);
  const SignalDataset read = ReadSignalDataset("named.dataset");
  EXPECT_EQ(read.Origin, dataset.Origin);
  EXPECT_EQ(read.License, dataset.License);
}

TEST(SignalDataset, UnspoiltContentIsAccepted)
{
  const FileContent content;
  WriteSafetensors("sound.dataset", content.Tensors, content.Metadata);
  EXPECT_EQ(ReadSignalDataset("sound.dataset").NumberOfSamples(), 2);
}

TEST(SignalDataset, AMissingFileIsInvalidInput) { EXPECT_THROW(ReadSignalDataset("no.dataset"), InvalidInput); }

TEST(SignalDataset, AnotherContentIsRefused)
{
  ExpectRefusal([](FileContent& file) { file.Metadata["content"] = "pictures"; }, "\"content\" is \"pictures\"");
  ExpectRefusal([](FileContent& file) { file.Metadata.erase("content"); }, "\"content\" is missing");
}

TEST(SignalDataset, AnotherVersionIsRefused)
{
  ExpectRefusal([](FileContent& file) { file.Metadata["format_version"] = "2"; }, "expected \"1\"");
}

TEST(SignalDataset, ASignalWithoutANameIsRefused)
{
  ExpectRefusal([](FileContent& file) { file.Metadata.erase("signal_name"); }, "\"signal_name\" is missing");
}

TEST(SignalDataset, AFileWithoutASurfaceIsRefused)
{
  ExpectRefusal([](FileContent& file) { file.Tensors.erase("sources.0.points"); }, "sources.0.points");
}

TEST(SignalDataset, AFileWithoutTrianglesIsRefused)
{
  ExpectRefusal([](FileContent& file) { file.Tensors.erase("sources.0.triangles"); }, "sources.0.triangles");
}

TEST(SignalDataset, PointsOfTwoCoordinatesAreRefused)
{
  ExpectRefusal(
    [](FileContent& file) {
      file.Tensors["sources.0.points"] = TensorData::FromFloat64({ 3, 2 }, { 0, 0, 1, 0, 0, 1 });
    },
    "the last of 2; expected 2, the last of 3");
}

TEST(SignalDataset, SignalsAtAnotherNumberOfVerticesAreRefused)
{
  ExpectRefusal(
    [](FileContent& file) {
      file.Tensors["sources.0.signals"] = TensorData::FromFloat32({ 2, 2, 1 }, { 1, 2, 3, 4 });
    },
    "signals at 2 vertices; expected 3");
}

TEST(SignalDataset, SignalsWithoutSamplesAreRefused)
{
  ExpectRefusal(
    [](FileContent& file) {
      file.Tensors["sources.0.signals"] = TensorData::FromFloat32({ 0, 3, 1 }, {});
    },
    "0 samples");
}

TEST(SignalDataset, IdsOutOfRangeAreRefused)
{
  for (const std::int64_t id : { std::int64_t(-1), std::int64_t(3), std::int64_t(1) << 40 })
  {
    ExpectRefusal(
      [id](FileContent& file) {
        file.Tensors["sources.0.triangles"] = TensorData::FromInt64({ 1, 3 }, { 0, 1, id });
      },
      "names vertex " + std::to_string(id));
  }
}

TEST(SignalDataset, NumbersThatAreNotFiniteAreRefused)
{
  ExpectRefusal(
    [](FileContent& file) {
      file.Tensors["sources.0.signals"] = TensorData::FromFloat32({ 1, 3, 1 }, { 0.0F, std::nanf(""), 0.0F });
    },
    "not finite");
}

TEST(SignalDataset, PositionsOfTwoComponentsAreRefused)
{
  ExpectRefusal(
    [](FileContent& file) {
      file.Metadata["signal_name"] = "Position";
      file.Tensors["sources.0.signals"] = TensorData::FromFloat32({ 1, 3, 2 }, { 1, 2, 3, 4, 5, 6 });
    },
    "expected 3 for each vertex");
}

TEST(SignalDataset, SourcesOfDifferentComponentsAreNotWritten)
{
  SignalDataset dataset = TwoTriangles(2);
  dataset.Sources[1] = TwoTriangles(1).Sources[1];
  EXPECT_THROW(WriteSignalDataset("mixed.dataset", dataset), InvalidInput);
  EXPECT_THROW(WriteSignalDataset("none.dataset", SignalDataset()), InvalidInput);
}

} // namespace

TEST(SignalDataset, FilesAreJudgedByTheirHeaders)
{
  const char* path = "sparse.dataset";
  const std::map<std::string, std::string> metadata = FileContent().Metadata;
  const std::int64_t samples = test::SparseBytes / 12;
  const auto refusal = [&](const test::SparseTensors& tensors) {
    test::WriteSparseModel(path, tensors, metadata);
    try
    {
      ReadSignalDataset(path);
    }
    catch (const std::exception& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  test::SparseTensors tensors = { { "sources.0.points", { "F64", { 3, 3 } } },
    { "sources.0.triangles", { "I64", { 1, 3 } } }, { "sources.0.signals", { "F32", { samples, 3, 1 } } } };
  const std::uint64_t before = test::PeakMemory();
  test::SparseTensors other = tensors;
  other["sources.0.points"] = { "F64", { 4, 3 } };
  EXPECT_THAT(refusal(other), HasSubstr("has signals at 3 vertices; expected 4"));
  other = tensors;
  other["sources.1.points"] = { "F64", { 3, 2 } };
  EXPECT_THAT(refusal(other), HasSubstr("\"sources.1.points\" has 2 dimensions, the last of 2"));
  other = tensors;
  other["sources.0.triangles"] = { "F32", { 1, 3 } };
  EXPECT_THAT(refusal(other), HasSubstr("is of type F32; expected I64"));
  tensors["sources.0.signals"] = { "F32", { 256 * samples, 3, 1 } };
  EXPECT_THAT(refusal(tensors), HasSubstr("takes about 8796.1 GB of memory; expected at most the"));
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove(path);
}
