// SPDX-License-Identifier: BSD-3-Clause
// Model files of PoissonNet: what is written is read, and what does not fit is named.
#include "RandomPoissonNet.h"
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>

using namespace surfsynth;
using testing::AllOf;
using testing::HasSubstr;

namespace
{

PoissonNetOptions SmallOptions()
{
  PoissonNetOptions options;
  options.Width = 4;
  options.Blocks = 1;
  options.ComplexLayers = 2;
  return options;
}

using Tensors = std::map<std::string, TensorData>;
using Metadata = std::map<std::string, std::string>;

/// The file of a small model after @p change; what reading it says.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  const PoissonNetModel model = test::RandomModel(SmallOptions());
  Tensors tensors;
  for (const auto& [name, tensor] : model.Tensors)
  {
    tensors[name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  Metadata metadata = MetadataFromOptions(model.Options);
  change(tensors, metadata);
  const std::vector<unsigned char> bytes = SerializeSafetensors(tensors, metadata);
  try
  {
    ReadPoissonNet(SafetensorsFile(bytes.data(), bytes.size(), "small.safetensors"));
  }
  catch (const ModelMismatch& error)
  {
    return std::string("ModelMismatch ") + error.what();
  }
  catch (const FormatError& error)
  {
    return std::string("FormatError ") + error.what();
  }
  return "accepted";
}

std::string MessageWith(const std::string& key, const std::string& value)
{
  return MessageAfter([&](Tensors&, Metadata& metadata) { metadata[key] = value; });
}

} // namespace

TEST(PoissonNetModel, WhatIsWrittenIsRead)
{
  for (int variant = 0; variant < 32; ++variant)
  {
    PoissonNetOptions options = SmallOptions();
    options.Modulate = (variant & 1) != 0;
    options.ModulateHead = options.Modulate && (variant & 16) != 0;
    options.InnerProducts = (variant & 2) != 0;
    options.Normalize = options.MassWeightedNorm = (variant & 4) != 0;
    options.ExtraFeatures = variant % 3;
    if ((variant & 8) != 0)
    {
      options.Head = PoissonNetHead::Linear;
      options.ModulateHead = options.Modulate; // a linear head has none; files say the same for both
      options.OutputChannels = 5;
      options.Domain = variant % 2 == 0 ? PoissonNetDomain::Faces : PoissonNetDomain::Global;
      options.Activation = LastActivation::LogSoftmax;
    }
    PoissonNetModel model = test::RandomModel(options, static_cast<std::uint64_t>(variant) + 1);
    model.Normalization = variant % 2 == 0 ? InputNormalization::SurfaceArea : InputNormalization::UnitSphere;
    model.Metadata["note"] = "kept";
    if (model.IsClassifier())
    {
      model.Classes = { "a", "b, c", "d", "\"e\"", "" };
    }
    const std::string path = "Written.safetensors";
    WritePoissonNet(path, model);
    const PoissonNetModel read = ReadPoissonNet(path);
    std::filesystem::remove(path);
    EXPECT_EQ(MetadataFromOptions(read.Options), MetadataFromOptions(options));
    EXPECT_EQ(read.Options.ModulateHead, options.ModulateHead);
    EXPECT_EQ(read.Normalization, model.Normalization);
    EXPECT_EQ(read.Classes, model.Classes);
    EXPECT_EQ(read.Metadata.at("note"), "kept");
    EXPECT_EQ(read.Metadata.at("architecture"), "poissonnet");
    EXPECT_EQ(read.Metadata.at("format_version"), "1");
    ASSERT_EQ(read.Tensors.size(), model.Tensors.size());
    for (const auto& [name, tensor] : model.Tensors)
    {
      EXPECT_EQ(read.Tensors.at(name).Shape, tensor.Shape) << name;
      EXPECT_EQ(read.Tensors.at(name).Values, tensor.Values) << name;
    }
  }
}

TEST(PoissonNetModel, PublishedFilesHaveFewerKeys)
{
  EXPECT_EQ(MessageAfter([](Tensors&, Metadata&) {}), "accepted");
  EXPECT_EQ(MessageAfter([](Tensors&, Metadata& metadata) {
    metadata.erase("extra_features");
    metadata.erase("outputs_at");
    metadata.erase("last_activation");
    metadata["config"] = R"({"cmlp_nlayers": 2, "lr": 5e-4, "clip_grad_norm": null, "nested": {"a": [1]}})";
  }),
    "accepted");
  EXPECT_EQ(MessageWith("classes", "left, up, forward"), "accepted");
}

TEST(PoissonNetModel, TensorsThatDifferAreNamed)
{
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("proj_in.bias"); }),
    AllOf(HasSubstr("ModelMismatch small.safetensors"), HasSubstr("\"proj_in.bias\" [4] is missing")));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["proj_in.weight"] = TensorData::FromFloat32({ 3, 4 }, std::vector<float>(12));
  }),
    HasSubstr("\"proj_in.weight\" is [3, 4] instead of [4, 3]"));
  EXPECT_THAT(
    MessageAfter([](Tensors& tensors, Metadata&) { tensors["more"] = TensorData::FromFloat32({}, { 1.0F }); }),
    HasSubstr("\"more\" does not belong to it"));
  EXPECT_THAT(MessageWith("n_blocks", "2"), AllOf(HasSubstr("\"blocks.1.grad_mlp"), HasSubstr("and ")));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["proj_in.bias"] = TensorData::FromInt64({ 4 }, { 1, 2, 3, 4 });
  }),
    HasSubstr("is of type I64; expected F64, F32, F16 or BF16"));
}

TEST(PoissonNetModel, WeightsThatAreNotFiniteAreRefused)
{
  for (const float bad : { std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity() })
  {
    EXPECT_THAT(MessageAfter([&](Tensors& tensors, Metadata&) {
      tensors["proj_in.bias"] = TensorData::FromFloat32({ 4 }, { 1.0F, 2.0F, bad, 4.0F });
    }),
      AllOf(HasSubstr("FormatError small.safetensors: byte "),
        HasSubstr("element 2 of tensor \"proj_in.bias\" is not finite")));
  }
}

TEST(PoissonNetModel, MetadataThatDoNotFitAreNamed)
{
  EXPECT_THAT(MessageWith("architecture", "unet"), HasSubstr("\"architecture\" is \"unet\"; expected \"poissonnet\""));
  EXPECT_THAT(MessageWith("format_version", "2"), HasSubstr("\"format_version\" is \"2\""));
  EXPECT_THAT(MessageWith("head", "mlp"), HasSubstr("\"head\" is \"mlp\"; expected one of linear, njf"));
  EXPECT_THAT(MessageWith("outputs_at", "edges"), HasSubstr("\"outputs_at\" is \"edges\""));
  EXPECT_THAT(MessageWith("last_activation", "relu"), HasSubstr("\"last_activation\" is \"relu\""));
  EXPECT_THAT(MessageWith("input_normalisation", "box"), HasSubstr("\"input_normalisation\" is \"box\""));
  EXPECT_THAT(MessageWith("classes", "a,b"), HasSubstr("\"classes\" has 2 names; expected 3"));
  EXPECT_THAT(MessageWith("classes", "[1, 2, 3]"), HasSubstr("\"classes\" holds something else than strings"));
  for (const char* number : { "", "-1", "0", "1.5", "four", "1000000000000", " 4" })
  {
    EXPECT_THAT(MessageWith("C_width", number), HasSubstr("ModelMismatch small.safetensors")) << number;
    EXPECT_THAT(MessageWith("n_blocks", number), HasSubstr("ModelMismatch small.safetensors")) << number;
  }
  EXPECT_THAT(MessageWith("C_in", "5"), HasSubstr("5 input channels"));
  for (const char* config :
    { "", "[]", "{", "{\"cmlp_nlayers\": \"2\"}", "{\"cmlp_nlayers\": -2}", "{}", "{\"cmlp_nlayers\": 0}",
      "{\"cmlp_nlayers\": 2, \"cmlp_modulate\": 1}", "{\"cmlp_nlayers\": 2, \"dropout_p\": 2}" })
  {
    EXPECT_THAT(MessageWith("config", config), HasSubstr("ModelMismatch small.safetensors")) << config;
  }
  EXPECT_THAT(MessageWith("config", std::string(1000000, '[')), HasSubstr("not a JSON object"));
  for (const char* key : { "config", "head", "C_in", "C_out", "C_width", "n_blocks" })
  {
    EXPECT_THAT(MessageAfter([&](Tensors&, Metadata& metadata) { metadata.erase(key); }),
      AllOf(HasSubstr("ModelMismatch"), HasSubstr("\"" + std::string(key) + "\" is missing")));
  }
}

TEST(PoissonNetModel, IncompleteModelsAreNotWritten)
{
  PoissonNetModel model = test::RandomModel(SmallOptions());
  model.Tensors.erase("proj_in.bias");
  EXPECT_THROW(WritePoissonNet("Never.safetensors", model), InvalidInput);
  model = test::RandomModel(SmallOptions());
  model.Tensors["proj_in.bias"].Values.pop_back();
  EXPECT_THROW(WritePoissonNet("Never.safetensors", model), InvalidInput);
  EXPECT_THROW(CheckModel(model), InvalidInput);
  EXPECT_NO_THROW(CheckModel(test::RandomModel(SmallOptions())));
  EXPECT_FALSE(std::filesystem::exists("Never.safetensors"));
}

TEST(PoissonNetModel, FilesAreJudgedByTheirHeaders)
{
  const char* path = "sparse.safetensors";
  const auto refusal = [&](const PoissonNetOptions& options, const test::SparseTensors& more) {
    test::SparseTensors tensors = more;
    for (const auto& [name, shape] : ExpectedTensors(options))
    {
      tensors[name] = { "F32", shape };
    }
    test::WriteSparseModel(path, tensors, MetadataFromOptions(options));
    try
    {
      ReadPoissonNet(path);
    }
    catch (const ModelMismatch& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::uint64_t before = test::PeakMemory();
  PoissonNetOptions options = SmallOptions();
  EXPECT_EQ(refusal(options, {}), "accepted");
  EXPECT_THAT(refusal(options, { { "stranger", { "F32", { test::SparseBytes / 4 } } } }),
    HasSubstr("\"stranger\" does not belong to it"));
  options.Width = 20000; // all of it is as the metadata say
  EXPECT_THAT(refusal(options, {}), HasSubstr("numbers; expected at most 268435456"));
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove(path);
}
