// SPDX-License-Identifier: BSD-3-Clause
// Model files of geometric textures: what is written is read, and what does not fit is named.
#include "ExampleMeshes.h"
#include "ModelFileChecks.h"
#include "RandomGeometricTexture.h"
#include "SparseModels.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

namespace
{
using test::Metadata;
using test::Tensors;

constexpr const char* Path = "GeometricTextureModel.safetensors";

const test::ModelFileKind Kind{ Path, "geometric_texture",
  [](const std::string& path) { WriteGeometricTexture(path, test::RandomGeometricTexture()); },
  [](const std::string& path) { ReadGeometricTexture(path); } };

/// Message of reading the file of a small model after @p change.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  return test::MessageAfter(Kind, change);
}

std::string MessageWithTensor(const std::string& name, const TensorData& tensor)
{
  return MessageAfter([&](Tensors& tensors, Metadata&) { tensors[name] = tensor; });
}

/// The same after the text @p from in the description has become @p to.
std::string MessageWith(const std::string& from, const std::string& to) { return test::MessageWith(Kind, from, to); }

std::string MessageOfCheck(const std::function<void(GeometricTextureModel&)>& change)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  change(model);
  try
  {
    CheckModel(model);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "accepted";
}

void ExpectSameTensors(
  const std::map<std::string, ModelTensor>& found, const std::map<std::string, ModelTensor>& written)
{
  ASSERT_EQ(found.size(), written.size());
  for (const auto& [name, tensor] : written)
  {
    EXPECT_EQ(found.at(name).Shape, tensor.Shape) << name;
    EXPECT_EQ(found.at(name).Values, tensor.Values) << name;
  }
}
} // namespace

TEST(GeometricTextureOptions, ChannelsFollowThePublishedRule)
{
  const GeometricTextureOptions options;
  EXPECT_THAT(options.GeneratorChannels(0), ElementsAre(4, 32, 32, 32, 32, 32, 3));
  EXPECT_THAT(options.GeneratorChannels(1), ElementsAre(4, 64, 32, 32, 32, 32, 3));
  EXPECT_THAT(options.GeneratorChannels(2), ElementsAre(4, 128, 64, 32, 32, 32, 3));
  EXPECT_THAT(options.GeneratorChannels(15), ElementsAre(4, 128, 64, 32, 32, 32, 3));
  EXPECT_THAT(options.DiscriminatorChannels(2), ElementsAre(4, 128, 64, 32, 32, 32, 1));
}

TEST(GeometricTextureOptions, TensorsHaveThePublishedNamesAndShapes)
{
  const auto generator = ExpectedGeometricTextureTensors({}, false);
  EXPECT_EQ(generator.size(), 60U);
  EXPECT_THAT(generator.at("levels.2.layers.0.0.conv.weight"), ElementsAre(128, 4, 1));
  EXPECT_THAT(generator.at("levels.2.layers.1.0.conv.weight"), ElementsAre(64, 256, 1));
  EXPECT_THAT(generator.at("levels.4.layers.5.conv.weight"), ElementsAre(3, 64, 1));
  EXPECT_THAT(generator.at("levels.4.layers.5.conv.bias"), ElementsAre(3));
  EXPECT_THAT(ExpectedGeometricTextureTensors({}, true).at("levels.0.layers.5.conv.weight"), ElementsAre(1, 64, 1));
}

TEST(GeometricTextureModel, WhatIsWrittenIsRead)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Options.NoiseAmplitude = 0.25;
  model.Metadata["note"] = "kept";
  WriteGeometricTexture(Path, model);
  const GeometricTextureModel read = ReadGeometricTexture(Path);
  EXPECT_EQ(read.Name, "pebbles");
  EXPECT_EQ(read.Options.Levels, model.Options.Levels);
  EXPECT_EQ(read.Options.Layers, model.Options.Layers);
  EXPECT_EQ(read.Options.StartChannels, model.Options.StartChannels);
  EXPECT_EQ(read.Options.MinimumChannels, model.Options.MinimumChannels);
  EXPECT_EQ(read.Options.MaximumChannels, model.Options.MaximumChannels);
  EXPECT_EQ(read.Options.NoiseAmplitude, 0.25);
  EXPECT_EQ(read.Metadata.at("note"), "kept");
  ExpectSameTensors(read.Generator, model.Generator);
  ExpectSameTensors(read.Discriminator, model.Discriminator);
  EXPECT_EQ(read.Template.Points, model.Template.Points) << "in double";
  EXPECT_EQ(read.Template.Triangles, model.Template.Triangles);
  EXPECT_EQ(read.ReconstructionNoise, model.ReconstructionNoise);
  EXPECT_EQ(
    read.Description(), "\"pebbles\": 2 levels of 4 convolutions with up to 8 channels; template of 20 triangles");
}

TEST(GeometricTextureModel, AGeneratorAloneIsAModel)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Discriminator.clear();
  model.Template = {};
  model.ReconstructionNoise.resize(0, 3);
  WriteGeometricTexture(Path, model);
  const GeometricTextureModel read = ReadGeometricTexture(Path);
  ExpectSameTensors(read.Generator, model.Generator);
  EXPECT_TRUE(read.Discriminator.empty());
  EXPECT_EQ(read.Template.NumberOfTriangles(), 0);
  EXPECT_THAT(read.Description(), HasSubstr("without a template"));
}

TEST(GeometricTextureModel, StatisticsOfChannelsBelongToAModelOrNot)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  const auto shapes = ExpectedGeometricTextureStatistics(model.Options);
  EXPECT_EQ(shapes.size(), 12U) << "mean and variance after three convolutions of two levels";
  EXPECT_THAT(shapes.at("levels.1.layers.0.mean"), ElementsAre(8));
  for (const auto& [name, shape] : shapes)
  {
    model.Statistics[name] = { shape, std::vector<float>(static_cast<std::size_t>(shape[0]), 0.5F) };
  }
  WriteGeometricTexture(Path, model);
  ExpectSameTensors(ReadGeometricTexture(Path).Statistics, model.Statistics);
  WriteGeometricTexture(Path, test::RandomGeometricTexture());
  EXPECT_TRUE(ReadGeometricTexture(Path).Statistics.empty());

  GeometricTextureModel broken = model;
  broken.Statistics.at("levels.0.layers.1.variance").Values[2] = -1.0F;
  EXPECT_THAT(MessageOf([&] { CheckModel(broken); }), HasSubstr("\"levels.0.layers.1.variance\" has a number below 0"));
  broken = model;
  broken.Statistics.erase("levels.0.layers.2.mean");
  EXPECT_THAT(MessageOf([&] { CheckModel(broken); }),
    AllOf(HasSubstr("\"levels.0.layers.2.mean\" [6] is missing"), HasSubstr("of the normalized channels")));
  EXPECT_THAT(
    MessageWithTensor("statistics.levels.0.layers.0.mean", TensorData::FromFloat32({ 6 }, std::vector<float>(6))),
    HasSubstr("\"statistics.levels.0.layers.0.variance\" [6] is missing"));
}

TEST(GeometricTextureModel, AFlowHasAFormatVersionAndStatisticsOfEachStep)
{
  GeometricTextureModel flow = test::RandomGeometricTexture();
  flow.Options.FlowSteps = 7;
  WriteGeometricTexture("flow.safetensors", flow);
  const GeometricTextureModel found = ReadGeometricTexture("flow.safetensors");
  EXPECT_EQ(found.Options.FlowSteps, 7);
  EXPECT_EQ(found.Metadata.at("format_version"), "2"); // versions before flows must not take it for another model
  EXPECT_THAT(found.Description(), HasSubstr("flow of 7 steps"));
  WriteGeometricTexture(Path, test::RandomGeometricTexture());
  EXPECT_EQ(ReadGeometricTexture(Path).Metadata.at("format_version"), "1");
  EXPECT_EQ(ReadGeometricTexture(Path).Options.FlowSteps, 0);
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["format_version"] = "2"; }),
    HasSubstr("\"flow_steps\" in the metadata"));
  EXPECT_THAT(MessageOfCheck([](auto& model) { model.Options.FlowSteps = 1001; }), HasSubstr("flow_steps is 1001"));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) {
    metadata["format_version"] = "2";
    metadata["geometric_texture"].replace(0, 1, "{\"flow_steps\":0,");
  }),
    HasSubstr("expected 1 to 1000"));
  flow.Statistics = MeasureStatistics(flow, 1);
  EXPECT_THAT(flow.Statistics.at("levels.1.layers.2.variance").Shape, testing::ElementsAre(7, 6));
  WriteGeometricTexture("flow.safetensors", flow);
  EXPECT_EQ(ReadGeometricTexture("flow.safetensors").Statistics.at("levels.1.layers.2.variance").Values,
    flow.Statistics.at("levels.1.layers.2.variance").Values);
  EXPECT_THAT(MessageOfCheck([](auto& model) {
    model.Statistics = MeasureStatistics(model, 1);
    model.Options.FlowSteps = 1;
  }),
    AllOf(HasSubstr("[6]"), HasSubstr("[1, 6]")));
}

TEST(GeometricTextureModel, MetadataAreChecked) { test::ExpectMetadataAreChecked(Kind); }

TEST(GeometricTextureModel, EachKeyOfTheDescriptionIsNeeded)
{
  test::ExpectKeysAreNeeded(
    Kind, { "name", "levels", "layers", "start_channels", "least_channels", "most_channels", "noise_amplitude" });
}

TEST(GeometricTextureModel, OptionsOutOfTheirRangeAreNamed)
{
  EXPECT_THAT(MessageWith("\"levels\":2", "\"levels\":2.5"), HasSubstr("expected a whole number"));
  EXPECT_THAT(MessageWith("\"levels\":2", "\"levels\":0"), HasSubstr("levels is 0; expected 1 to 16"));
  EXPECT_THAT(MessageWith("\"levels\":2", "\"levels\":1000000"), HasSubstr("levels is 1000000"));
  EXPECT_THAT(MessageWith("\"layers\":5", "\"layers\":2"), HasSubstr("layers is 2; expected 3 to 32"));
  EXPECT_THAT(MessageWith("\"start_channels\":6", "\"start_channels\":0"), HasSubstr("start_channels is 0"));
  EXPECT_THAT(MessageWith("\"least_channels\":6", "\"least_channels\":5000"), HasSubstr("least_channels is 5000"));
  EXPECT_THAT(MessageWith("\"most_channels\":8", "\"most_channels\":0"), HasSubstr("most_channels is 0"));
  EXPECT_THAT(MessageWith("\"noise_amplitude\":0.1", "\"noise_amplitude\":-1"), HasSubstr("noise_amplitude is -1"));
  EXPECT_THAT(MessageWith("\"noise_amplitude\":0.1", "\"noise_amplitude\":\"much\""), HasSubstr("expected a number"));
  EXPECT_THAT(MessageWith("\"pebbles\"", "\"\""), HasSubstr("expected a name"));
}

TEST(GeometricTextureModel, TensorsThatDoNotFitAreNamed)
{
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("levels.0.layers.0.0.conv.bias"); }),
    HasSubstr("\"levels.0.layers.0.0.conv.bias\" [6] is missing"));
  EXPECT_THAT(MessageWithTensor("levels.0.layers.0.0.conv.bias", TensorData::FromFloat32({ 2 }, { 1.0F, 2.0F })),
    HasSubstr("is [2] instead of [6]"));
  EXPECT_THAT(MessageWithTensor("levels.2.layers.0.0.conv.bias", TensorData::FromFloat32({ 1 }, { 1.0F })),
    HasSubstr("\"levels.2.layers.0.0.conv.bias\" does not belong to it"));
  EXPECT_THAT(
    MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("discriminator.levels.1.layers.3.conv.bias"); }),
    HasSubstr("\"discriminator.levels.1.layers.3.conv.bias\" [1] is missing"));
  EXPECT_THAT(MessageWith("\"layers\":5", "\"layers\":6"), HasSubstr("the tensors are not those"));
}

TEST(GeometricTextureModel, WeightsOfAnotherKindAreRefused)
{
  EXPECT_THAT(MessageWithTensor("levels.0.layers.3.conv.bias",
                TensorData::FromFloat32({ 3 }, { 0.0F, std::numeric_limits<float>::quiet_NaN(), 0.0F })),
    AllOf(HasSubstr("FormatError"), HasSubstr("levels.0.layers.3.conv.bias")));
  EXPECT_THAT(MessageWithTensor("levels.0.layers.3.conv.bias", TensorData::FromInt64({ 3 }, { 1, 2, 3 })),
    AllOf(HasSubstr("ModelMismatch"), HasSubstr("levels.0.layers.3.conv.bias")));
}

TEST(GeometricTextureModel, APartOfATemplateIsNone)
{
  for (const std::string name : { "template.points", "template.triangles", "reconstruction_noise" })
  {
    EXPECT_THAT(MessageAfter([&](Tensors& tensors, Metadata&) { tensors.erase(name); }),
      AllOf(HasSubstr("\"" + name + "\""), HasSubstr("is missing")));
  }
}

TEST(GeometricTextureModel, ABrokenTemplateIsNamed)
{
  const auto withTriangle = [](std::vector<std::int64_t> ids) {
    return MessageAfter([&](Tensors& tensors, Metadata&) {
      tensors["template.triangles"] = TensorData::FromInt64({ 1, 3 }, ids);
    });
  };
  EXPECT_EQ(withTriangle({ 0, 1, 2 }), "accepted");
  EXPECT_THAT(withTriangle({ 0, 1, 12 }), HasSubstr("the template is broken"));
  EXPECT_THAT(withTriangle({ 0, 1, std::int64_t(1) << 32 }), HasSubstr("the template is broken"));
  EXPECT_THAT(withTriangle({ 0, 1, -(std::int64_t(1) << 32) }), HasSubstr("the template is broken"));
  EXPECT_THAT(withTriangle({ 0, 1, 1 }), HasSubstr("the template is broken"));
  EXPECT_THAT(MessageWithTensor("template.triangles", TensorData::FromInt64({ 0, 3 }, {})),
    HasSubstr("the template has 0 triangles"));
  EXPECT_THAT(MessageWithTensor("template.triangles", TensorData::FromFloat32({ 1, 3 }, { 0.0F, 1.0F, 2.0F })),
    AllOf(HasSubstr("ModelMismatch"), HasSubstr("template.triangles")));
  EXPECT_THAT(MessageWithTensor("reconstruction_noise", TensorData::FromFloat32({ 1, 3 }, { 0.0F, 1.0F, 2.0F })),
    HasSubstr("\"reconstruction_noise\" is [1, 3] instead of [12, 3]"));
  EXPECT_THAT(MessageWithTensor("template.points", TensorData::FromFloat32({ 3 }, { 0.0F, 1.0F, 2.0F })),
    HasSubstr("\"template.points\" is [3] instead of [3, 3]"));
  std::vector<double> points(36, 1.0);
  points[7] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(
    MessageWithTensor("template.points", TensorData::FromFloat64({ 12, 3 }, points)), HasSubstr("FormatError"));
}

TEST(GeometricTextureModel, ModelsMadeByHandAreChecked)
{
  EXPECT_EQ(MessageOfCheck([](GeometricTextureModel&) {}), "accepted");
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) { model.Options.Levels = 3; }),
    AllOf(HasSubstr("of the generator are not those of the options"), HasSubstr("levels.2")));
  EXPECT_THAT(
    MessageOfCheck([](GeometricTextureModel& model) { model.Discriminator.erase(model.Discriminator.begin()); }),
    HasSubstr("of the discriminator"));
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) { model.Generator.begin()->second.Values.pop_back(); }),
    HasSubstr("finite ones"));
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) {
    model.Generator.begin()->second.Values[0] = std::numeric_limits<float>::infinity();
  }),
    HasSubstr("not all finite"));
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) { model.Name.clear(); }), HasSubstr("expected a name"));
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) { model.ReconstructionNoise.conservativeResize(3, 3); }),
    HasSubstr("noise at 3"));
  EXPECT_THAT(MessageOfCheck([](GeometricTextureModel& model) { model.Template.Triangles.row(0).reverseInPlace(); }),
    HasSubstr("the template is broken"));
}

TEST(GeometricTextureModel, AFileThatIsNotThere)
{
  EXPECT_THROW(ReadGeometricTexture("nowhere.safetensors"), InvalidInput);
}

TEST(GeometricTextureModel, FilesAreJudgedByTheirHeaders)
{
  WriteGeometricTexture(Path, test::RandomGeometricTexture());
  const SafetensorsFile small(Path);
  const std::map<std::string, std::string> metadata = small.Metadata();
  test::SparseTensors tensors;
  for (const auto& [name, entry] : small.Tensors())
  {
    tensors[name] = { std::string(TypeName(entry.Type)), entry.Shape };
  }
  const char* path = "sparse.safetensors";
  const auto refusal = [&](const test::SparseTensors& content) {
    test::WriteSparseModel(path, content, metadata);
    try
    {
      ReadGeometricTexture(path);
    }
    catch (const ModelMismatch& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::uint64_t before = test::PeakMemory();
  tensors["template.points"] = { "F64", { test::SparseBytes / 24, 3 } };
  tensors["reconstruction_noise"] = { "F32", { 1, 3 } };
  EXPECT_THAT(refusal(tensors), HasSubstr("\"reconstruction_noise\" is [1, 3] instead of [715827882, 3]"));
  tensors["reconstruction_noise"] = { "F32", { test::SparseBytes / 24, 3 } };
  EXPECT_THAT(refusal(tensors), HasSubstr("numbers; expected at most 268435456"));
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove(path);
}
