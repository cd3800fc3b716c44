// SPDX-License-Identifier: BSD-3-Clause
// Model files of flow matching: what is written is read, and what does not fit is named.
#include "ExampleMeshes.h"
#include "ModelFileChecks.h"
#include "RandomFlowMatching.h"
#include "RandomPoissonNet.h"

#include "Core/Common/Errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

using namespace surfsynth;
using testing::AllOf;
using testing::HasSubstr;

namespace
{

using test::Metadata;
using test::Tensors;

constexpr const char* Path = "FlowMatchingModel.safetensors";

FlowMatchingModel SmallModel()
{
  FlowMatchingModel model = test::RandomSignalModel(test::Icosphere(1), 2);
  test::AddRandomEncoder(model, 3);
  return model;
}

const test::ModelFileKind Kind{ Path, "flow_matching",
  [](const std::string& path) { WriteFlowMatchingModel(path, SmallModel()); },
  [](const std::string& path) { ReadFlowMatchingModel(path); } };

/// Message of reading the file of a small model after @p change.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  return test::MessageAfter(Kind, change);
}

/// The same after the text @p from in the description has become @p to.
std::string MessageWith(const std::string& from, const std::string& to) { return test::MessageWith(Kind, from, to); }

std::string MessageOfCheck(const std::function<void(FlowMatchingModel&)>& change)
{
  FlowMatchingModel model = SmallModel();
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

} // namespace

TEST(FlowMatchingModel, WhatIsWrittenIsRead)
{
  for (const NoiseModel noise :
    { NoiseModel::Matern, NoiseModel::PerVertex, NoiseModel::White, NoiseModel::Unscreened, NoiseModel::Spectral })
  {
    FlowMatchingModel model = SmallModel();
    model.Noise.Model = noise;
    model.Noise.Screening = 12.5;
    model.Noise.Eigenpairs = 17;
    model.Noise.Scale = 0.1;
    model.Noise.Smoothing = 0.003;
    model.Shape.Spread = 0.3;
    model.Iterations = 4321;
    model.Metadata["note"] = "kept";
    WriteFlowMatchingModel(Path, model);
    const FlowMatchingModel read = ReadFlowMatchingModel(Path);
    EXPECT_EQ(read.SignalName, "Mixture");
    EXPECT_EQ(read.SignalMean, model.SignalMean);
    EXPECT_EQ(read.SignalScale, model.SignalScale);
    EXPECT_EQ(read.Noise.Model, noise);
    EXPECT_EQ(read.Noise.Screening, 12.5);
    EXPECT_EQ(read.Noise.Eigenpairs, 17);
    EXPECT_EQ(read.Noise.Scale, 0.1);
    EXPECT_EQ(read.Noise.Smoothing, 0.003);
    EXPECT_EQ(read.Shape.Mean, model.Shape.Mean);
    EXPECT_EQ(read.Shape.Spread, 0.3);
    EXPECT_EQ(read.Iterations, 4321);
    EXPECT_EQ(read.Metadata.at("note"), "kept");
    ASSERT_TRUE(read.Encoder);
    using Networks = std::pair<const PoissonNetModel*, const PoissonNetModel*>;
    for (const auto& [written, found] :
      { Networks(&model.Velocity, &read.Velocity), Networks(&*model.Encoder, &*read.Encoder) })
    {
      EXPECT_EQ(MetadataFromOptions(found->Options), MetadataFromOptions(written->Options));
      ASSERT_EQ(found->Tensors.size(), written->Tensors.size());
      for (const auto& [name, tensor] : written->Tensors)
      {
        EXPECT_EQ(found->Tensors.at(name).Shape, tensor.Shape) << name;
        EXPECT_EQ(found->Tensors.at(name).Values, tensor.Values) << name;
      }
    }
  }
}

TEST(FlowMatchingModel, ModelsThatPredictDataHaveAVersionOfTheirOwn)
{
  FlowMatchingModel model = test::RandomDeformer(test::Icosphere(1));
  WriteFlowMatchingModel(Path, model);
  EXPECT_EQ(ReadFlowMatchingModel(Path).Prediction, FlowPrediction::Velocity);
  EXPECT_EQ(ReadFlowMatchingModel(Path).Metadata.at("format_version"), "1");
  model.Prediction = FlowPrediction::Data;
  model.DataDeviation = 0.03125;
  model.Temperature = 1.25;
  WriteFlowMatchingModel(Path, model);
  const FlowMatchingModel read = ReadFlowMatchingModel(Path);
  EXPECT_EQ(read.Prediction, FlowPrediction::Data);
  EXPECT_EQ(read.DataDeviation, 0.03125);
  EXPECT_EQ(read.Temperature, 1.25);
  EXPECT_THAT(read.Description(), HasSubstr("; temperature 1.25"));
  EXPECT_EQ(read.Metadata.at("format_version"), "2");
  model.Prediction = FlowPrediction::Preconditioned;
  WriteFlowMatchingModel(Path, model);
  EXPECT_EQ(ReadFlowMatchingModel(Path).Prediction, FlowPrediction::Preconditioned);
  EXPECT_EQ(ReadFlowMatchingModel(Path).Metadata.at("format_version"), "2");
  EXPECT_THAT(MessageWith("\"signal_name\"", "\"prediction\":\"noise\",\"signal_name\""),
    AllOf(HasSubstr("prediction"), HasSubstr("velocity, data or preconditioned")));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["format_version"] = "3"; }),
    AllOf(HasSubstr("format_version"), HasSubstr("\"3\"")));
  for (const double deviation : { 0.0, -1.0, std::numeric_limits<double>::infinity() })
  {
    EXPECT_THAT(MessageOfCheck([=](FlowMatchingModel& m) { m.DataDeviation = deviation; }),
      HasSubstr("the deviation of the data is"));
  }
  for (const double temperature : { -0.5, 11.0, std::nan("") })
  {
    EXPECT_THAT(MessageOfCheck([=](FlowMatchingModel& m) { m.Temperature = temperature; }),
      AllOf(HasSubstr("the temperature is"), HasSubstr("from 0 to 10")));
  }
}

TEST(FlowMatchingModel, EarlierModelsOfOtherNoiseAreNotSmoothed)
{
  // Earlier versions wrote the smoothing of each kind of noise, and smoothed Matern noise only.
  const auto earlier = [](Tensors&, Metadata& metadata) {
    std::string& text = metadata["flow_matching"];
    for (const auto& [from, to] : { std::pair<std::string, std::string>("\"matern\"", "\"white\""),
           std::pair<std::string, std::string>("\"noise_smoothing\":0.0", "\"noise_smoothing\":0.25") })
    {
      text.replace(text.find(from), from.size(), to);
    }
  };
  ASSERT_EQ(MessageAfter(earlier), "accepted");
  const FlowMatchingModel read = ReadFlowMatchingModel(Path);
  EXPECT_EQ(read.Noise.Model, NoiseModel::White);
  EXPECT_EQ(read.Noise.Smoothing, 0.0);
}

TEST(FlowMatchingModel, DeformersAreReadToo)
{
  WriteFlowMatchingModel(Path, test::RandomDeformer(test::Icosphere(1)));
  const FlowMatchingModel read = ReadFlowMatchingModel(Path);
  EXPECT_TRUE(read.GeneratesPositions());
  EXPECT_FALSE(read.Encoder);
  EXPECT_THAT(read.Description(),
    AllOf(
      HasSubstr("deformations from matern noise"), HasSubstr("2 blocks of width 16"), HasSubstr("for one surface")));
}

TEST(FlowMatchingModel, TheDescriptionCountsInSingularAndPlural)
{
  FlowMatchingModel model;
  model.SignalName = "Heat";
  model.Velocity.Options.InputChannels = 1;
  model.Velocity.Options.Blocks = 1;
  model.Iterations = 1;
  EXPECT_THAT(model.Description(), HasSubstr("\"Heat\", 1 component from matern noise; 1 block of width "));
  EXPECT_THAT(model.Description(), HasSubstr("; 1 iteration of training"));
  model.Velocity.Options.InputChannels = 2;
  model.Velocity.Options.Blocks = 3;
  model.Iterations = 20;
  EXPECT_THAT(model.Description(), HasSubstr("\"Heat\", 2 components from matern noise; 3 blocks of width "));
  EXPECT_THAT(model.Description(), HasSubstr("; 20 iterations of training"));
}

TEST(FlowMatchingModel, MetadataAreChecked) { test::ExpectMetadataAreChecked(Kind); }

TEST(FlowMatchingModel, EachKeyOfTheDescriptionIsNeeded)
{
  test::ExpectKeysAreNeeded(Kind,
    { "signal_name", "signal_mean", "signal_scale", "noise", "noise_screening", "noise_eigenpairs", "noise_scale",
      "iterations", "shape_moments", "shape_spread" });
}

TEST(FlowMatchingModel, ValuesOfAnotherKindAreNamed)
{
  EXPECT_THAT(MessageWith("\"Mixture\"", "7"), AllOf(HasSubstr("\"signal_name\""), HasSubstr("is 7; expected a name")));
  EXPECT_THAT(MessageWith("\"Mixture\"", "\"\""), HasSubstr("expected a name"));
  EXPECT_THAT(MessageWith("\"matern\"", "\"pink\""), AllOf(HasSubstr("\"pink\""), HasSubstr("spectral")));
  EXPECT_THAT(MessageWith("\"noise_screening\":100.0", "\"noise_screening\":\"much\""), HasSubstr("expected a number"));
  EXPECT_THAT(
    MessageWith("\"noise_eigenpairs\":256", "\"noise_eigenpairs\":2.5"), HasSubstr("expected a whole number"));
  EXPECT_THAT(MessageWith("\"iterations\":0", "\"iterations\":-1"), HasSubstr("expected a whole number"));
  EXPECT_THAT(MessageWith("\"signal_mean\":[2.0,", "\"signal_mean\":[null,"), HasSubstr("an array of numbers"));
  EXPECT_THAT(MessageWith("\"shape_moments\":[", "\"shape_moments\":[1.0,"), HasSubstr("has 7 numbers; expected 6"));
}

TEST(FlowMatchingModel, ValuesOutOfTheirRangeAreNamed)
{
  EXPECT_THAT(MessageWith("\"signal_mean\":[2.0,", "\"signal_mean\":["), HasSubstr("2 finite ones each"));
  EXPECT_THAT(MessageWith("\"signal_scale\":[0.5,", "\"signal_scale\":[0.0,"), HasSubstr("the scales above 0"));
  EXPECT_THAT(MessageWith("\"noise_screening\":100.0", "\"noise_screening\":0"), HasSubstr("screening 0"));
  EXPECT_THAT(MessageWith("\"noise_scale\":1.0", "\"noise_scale\":-1"), HasSubstr("scale -1"));
  EXPECT_THAT(
    MessageWith("\"noise_smoothing\":0.0", "\"noise_smoothing\":-1"), HasSubstr("smoothing of the noise is -1"));
  EXPECT_THAT(MessageWith("\"noise_eigenpairs\":256", "\"noise_eigenpairs\":0"), HasSubstr("0 eigenpairs"));
  EXPECT_THAT(MessageWith("\"shape_spread\":0.0", "\"shape_spread\":-1"), HasSubstr("spread of at least 0"));
}

TEST(FlowMatchingModel, TensorsThatDoNotFitAreNamed)
{
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("velocity.proj_in.bias"); }),
    AllOf(HasSubstr("(velocity)"), HasSubstr("\"proj_in.bias\" [16] is missing")));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["velocity.proj_in.bias"] = TensorData::FromFloat32({ 4 }, std::vector<float>(4));
  }),
    HasSubstr("\"proj_in.bias\" is [4] instead of [16]"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["encoder.more"] = TensorData::FromFloat32({ 1 }, { 1.0F });
  }),
    AllOf(HasSubstr("(encoder)"), HasSubstr("\"more\" does not belong to it")));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["proj_in.bias"] = TensorData::FromFloat32({ 1 }, { 1.0F });
  }),
    HasSubstr("\"proj_in.bias\" does not belong to a flow matching model"));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata.erase("encoder"); }),
    HasSubstr("does not belong to a flow matching model"));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata.erase("velocity"); }),
    HasSubstr("\"velocity\" is missing"));
  EXPECT_THAT(MessageAfter([](Tensors&, Metadata& metadata) { metadata["velocity"] = "{\"n_blocks\": 2}"; }),
    HasSubstr("expected a JSON object of strings"));
}

TEST(FlowMatchingModel, WeightsThatAreNotFiniteAreRefused)
{
  const float bad = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(MessageAfter([&](Tensors& tensors, Metadata&) {
    tensors["velocity.proj_in.bias"] = TensorData::FromFloat32({ 16 }, std::vector<float>(16, bad));
  }),
    AllOf(HasSubstr("FormatError"), HasSubstr("velocity.proj_in.bias")));
}

TEST(FlowMatchingModel, NetworksThatDoNotFitTogetherAreNamed)
{
  // As read from a file: the encoder has gone, and with it three conditions.
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata& metadata) {
    metadata.erase("encoder");
    for (auto entry = tensors.begin(); entry != tensors.end();)
    {
      entry = entry->first.rfind("encoder.", 0) == 0 ? tensors.erase(entry) : std::next(entry);
    }
  }),
    AllOf(HasSubstr("ModelMismatch"), HasSubstr("takes 7 conditions; expected 4")));
  const auto withVelocity = [](const std::function<void(PoissonNetOptions&)>& change) {
    return MessageOfCheck([&](FlowMatchingModel& model) {
      PoissonNetOptions options = model.Velocity.Options;
      change(options);
      model.Velocity = test::RandomModel(options);
    });
  };
  EXPECT_THAT(withVelocity([](PoissonNetOptions& options) { options.OutputChannels = 5; }),
    HasSubstr("gives 5 channels for a signal of 2"));
  EXPECT_THAT(withVelocity([](PoissonNetOptions& options) { options.Domain = PoissonNetDomain::Faces; }),
    HasSubstr("at the vertices"));
  EXPECT_THAT(withVelocity([](PoissonNetOptions& options) { options.Activation = LastActivation::LogSoftmax; }),
    HasSubstr("without a last activation"));
  EXPECT_THAT(MessageOfCheck([](FlowMatchingModel& model) { model.SignalName = "Position"; }),
    HasSubstr("positions have 2 channels; expected 3"));
  EXPECT_THAT(MessageOfCheck([](FlowMatchingModel& model) {
    PoissonNetOptions options = model.Encoder->Options;
    options.ExtraFeatures = 1;
    model.Encoder = test::RandomModel(options);
  }),
    HasSubstr("the encoder takes 3 channels and 1 conditions"));
}

TEST(FlowMatchingModel, AFileThatIsNotThere)
{
  EXPECT_THROW(ReadFlowMatchingModel("nowhere.safetensors"), InvalidInput);
}

// --- Moments --------------------------------------------------------------------------------------------------------

// A square of side 1: the second moment along a side is 1/12.
TEST(ShapeMoments, OfASquareAreKnown)
{
  for (const TriangleMesh& square : { test::PlanePatch(1, 1), test::PlanePatch(9, 7, 1.0, 1.0, 0.2),
         test::Translated(test::PlanePatch(3, 3), { 1e6, -2e6, 5.0 }) })
  {
    Eigen::Matrix<double, 1, 6> expected;
    expected << 1.0 / 12.0, 0.0, 0.0, 1.0 / 12.0, 0.0, 0.0;
    EXPECT_LE((SecondMoments(square) - expected).cwiseAbs().maxCoeff(), 1e-9);
  }
}

// The halves of a square about its center: moments of parts add up, and no part has more than the whole.
TEST(ShapeMoments, OfPartsAddUpToThoseOfTheWhole)
{
  const TriangleMesh square = test::Translated(test::PlanePatch(8, 8), { -0.5, -0.5, 0.0 });
  Eigen::Matrix<double, 1, 6> sum = Eigen::Matrix<double, 1, 6>::Zero();
  for (const double left : { -0.5, 0.0 })
  {
    const TriangleMesh half = test::Translated(test::PlanePatch(4, 8, 0.5, 1.0), { left, -0.5, 0.0 });
    const Eigen::Matrix<double, 1, 6> part = PartMoments(half);
    EXPECT_NEAR(part[0], 1.0 / 24.0, 1e-12);
    EXPECT_LE(MomentExcess(SecondMoments(square), part), 1e-12);
    sum += part;
  }
  EXPECT_LE((sum - SecondMoments(square)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(MomentExcess(SecondMoments(square), 2.0 * sum), 0.5, 1e-12) << "twice as much along each of two sides";
}

TEST(ShapeMoments, DoNotDependOnTheTriangulationAndNoticeATurn)
{
  const auto moments = [](
                         const TriangleMesh& mesh) { return SecondMoments(Normalized(mesh, FlowNormalization(mesh))); };
  const TriangleMesh torus = test::Torus(16, 10);
  EXPECT_LE(MomentDistance(moments(torus), moments(test::Subdivide(torus))), 1e-12);
  TriangleMesh turned = torus;
  turned.Points.col(1).swap(turned.Points.col(2));
  turned.Points.col(1) *= -1.0;
  EXPECT_GT(MomentDistance(moments(torus), moments(turned)), 0.3);
}
