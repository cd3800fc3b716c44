// SPDX-License-Identifier: BSD-3-Clause
// The fast path against the differentiable one, and its contracts.
#include "ExampleMeshes.h"
#include "RandomPoissonNet.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"
#include "Learning/Networks/PoissonNet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{

/// About unit area; more faces than one patch holds, and unused points.
const TriangleMesh& Surface()
{
  static const TriangleMesh mesh = test::WithUnreferencedPoints(test::Scaled(test::IrregularSphere(3), 0.28));
  return mesh;
}

FeatureMatrix RandomFeatures(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed)
{
  FeatureMatrix features(rows, columns);
  for (Eigen::Index k = 0; k < features.size(); ++k)
  {
    features.data()[k] = static_cast<float>(test::Uniform(seed, static_cast<std::uint64_t>(k)));
  }
  return features;
}

torch::Tensor ToTensor(const FeatureMatrix& matrix)
{
  return torch::from_blob(const_cast<float*>(matrix.data()), { matrix.rows(), matrix.cols() }, torch::kFloat32)
    .to(torch::kFloat64);
}

double RelativeError(const FeatureMatrix& found, const torch::Tensor& expected)
{
  const torch::Tensor exact = expected.reshape({ found.rows(), found.cols() });
  return ((ToTensor(found) - exact).norm() / exact.norm()).item<double>();
}

bool SameBits(const FeatureMatrix& a, const FeatureMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() &&
    std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(float)) == 0;
}

std::shared_ptr<const PoissonNetModel> Model(const PoissonNetOptions& options)
{
  return std::make_shared<const PoissonNetModel>(test::RandomModel(options));
}

PoissonNetOptions SmallOptions()
{
  PoissonNetOptions options;
  options.Width = 20;
  options.Blocks = 2;
  options.ModulateHead = true;
  return options;
}

} // namespace

// --- Equality -------------------------------------------------------------------------------------------------------

TEST(PoissonNetEvaluator, EqualsTheDifferentiableNetworkInEveryVariant)
{
  for (int variant = 0; variant < 48; ++variant)
  {
    PoissonNetOptions options = SmallOptions();
    options.Width = 20 + 13 * (variant % 2); // no multiple of what vectors or solver blocks hold
    options.ComplexLayers = 1 + variant % 3;
    options.Modulate = (variant & 1) == 0;
    options.ModulateHead = (variant & 2) == 0;
    options.InnerProducts = (variant & 4) != 0;
    options.Normalize = (variant & 8) != 0;
    options.MassWeightedNorm = variant % 5 == 0;
    options.ExtraFeatures = variant % 4 == 3 ? 0 : 3;
    if (variant >= 24)
    {
      options.Head = PoissonNetHead::Linear;
      options.OutputChannels = 6;
      options.InputChannels = 4;
      options.Domain = static_cast<PoissonNetDomain>(variant % 3);
      options.Activation = variant % 7 == 0 ? LastActivation::Identity : LastActivation::LogSoftmax;
    }
    const auto model = std::make_shared<const PoissonNetModel>(
      test::RandomModel(options, static_cast<std::uint64_t>(variant) + 1));
    const PoissonNetEvaluator evaluator(model, Surface());
    PoissonNetInput input;
    input.Signal = RandomFeatures(Surface().NumberOfPoints(), options.InputChannels, 7);
    if (options.ExtraFeatures > 0)
    {
      input.Extra = RandomFeatures(variant % 2 == 0 ? 1 : Surface().NumberOfPoints(), options.ExtraFeatures, 8);
    }
    const PoissonNetPrediction found = evaluator.Evaluate(input);

    PoissonNet network = MakePoissonNet(*model);
    network->to(torch::kFloat64);
    const torch::NoGradGuard noGradients;
    const PoissonNetOutput expected = network->forward(MeshTensors(evaluator.Operators(), torch::kFloat64),
      ToTensor(input.Signal), options.ExtraFeatures > 0 ? ToTensor(input.Extra) : torch::Tensor());
    EXPECT_EQ(found.Domain, options.Domain);
    EXPECT_LE(RelativeError(found.Values, expected.Values), 1e-5) << "variant " << variant;
    ASSERT_EQ(found.Gradients.size() > 0, expected.Gradients.defined());
    if (expected.Gradients.defined())
    {
      EXPECT_LE(RelativeError(found.Gradients, expected.Gradients), 1e-5) << "variant " << variant;
    }
  }
}

TEST(PoissonNetEvaluator, PositionsAreTheDefaultSignal)
{
  const PoissonNetEvaluator evaluator(Model(SmallOptions()), Surface());
  PoissonNetInput input;
  input.Signal = Surface().Points.cast<float>();
  EXPECT_TRUE(SameBits(evaluator.Evaluate().Values, evaluator.Evaluate(input).Values));
  EXPECT_TRUE(SameBits(evaluator.Evaluate().Values, EvaluatePoissonNet(evaluator.Model(), Surface()).Values));
}

TEST(PoissonNetEvaluator, BitsAreTheSameForEveryNumberOfThreads)
{
  PoissonNetOptions options = SmallOptions();
  options.Width = 64; // two blocks of columns
  options.InnerProducts = true;
  const auto model = Model(options);
  std::unique_ptr<PoissonNetPrediction> first;
  for (const int threads : { 1, 2, 3, 5 })
  {
    const ThreadScope scope(threads);
    const PoissonNetEvaluator evaluator(model, Surface());
    for (int repeat = 0; repeat < 3; ++repeat)
    {
      const PoissonNetPrediction prediction = evaluator.Evaluate();
      if (!first)
      {
        first = std::make_unique<PoissonNetPrediction>(prediction);
      }
      EXPECT_TRUE(SameBits(prediction.Values, first->Values)) << threads;
      EXPECT_TRUE(SameBits(prediction.Gradients, first->Gradients)) << threads;
    }
  }
}

// --- Normalisation and warnings ------------------------------------------------------------------------------------

TEST(PoissonNetEvaluator, NormalizedMeshesOfAnySizeAndPlaceGiveTheSame)
{
  for (const InputNormalization normalization : { InputNormalization::SurfaceArea, InputNormalization::UnitSphere })
  {
    auto model = std::make_shared<PoissonNetModel>(test::RandomModel(SmallOptions()));
    model->Normalization = normalization;
    const PoissonNetEvaluator here(model, Surface());
    const PoissonNetEvaluator there(model, test::Translated(test::Scaled(Surface(), 1000.0), { 5e4, -2e4, 1e4 }));
    EXPECT_LE((here.Evaluate().Values - there.Evaluate().Values).norm(), 1e-3F * here.Evaluate().Values.norm());
    EXPECT_NEAR(there.Normalization().Scale / here.Normalization().Scale, 1000.0, 1e-3);
    EXPECT_THAT(there.Warnings(), IsEmpty());
    for (const int power : { -40, 20 })
    {
      const PoissonNetEvaluator scaled(model, test::Scaled(Surface(), std::ldexp(1.0, power)));
      EXPECT_EQ(here.Evaluate().Values, scaled.Evaluate().Values) << "2^" << power;
    }
  }
  const MeshNormalization sphere = ComputeNormalization(
    test::Translated(test::Icosphere(4, 2.0), { 1, 2, 3 }), InputNormalization::SurfaceArea);
  EXPECT_NEAR(sphere.Scale, std::sqrt(4.0 * 3.14159265 * 4.0), 0.02);
  EXPECT_LE((sphere.Center - Eigen::RowVector3d(1, 2, 3)).norm(), 1e-9);
  EXPECT_NEAR(ComputeNormalization(test::Icosphere(2, 2.0), InputNormalization::UnitSphere).Scale, 2.0, 1e-9);
}

TEST(PoissonNetEvaluator, WarnsOfInwardFacesAndOfAreasFarFromOne)
{
  const auto model = Model(SmallOptions());
  EXPECT_THAT(PoissonNetEvaluator(model, Surface()).Warnings(), IsEmpty());
  TriangleMesh inwards = Surface();
  inwards.Triangles.col(0).swap(inwards.Triangles.col(1));
  EXPECT_THAT(PoissonNetEvaluator(model, inwards).Warnings(), ElementsAre(HasSubstr("point inwards")));
  EXPECT_THAT(
    PoissonNetEvaluator(model, test::Scaled(Surface(), 10.0)).Warnings(), ElementsAre(HasSubstr("an area of ")));
  EXPECT_THAT(
    PoissonNetEvaluator(model, test::PlanePatch(4, 4)).Warnings(), IsEmpty()); // an open surface has no inside
}

// --- Errors ---------------------------------------------------------------------------------------------------------

TEST(PoissonNetEvaluator, MeshesThatItCannotTakeAreNamed)
{
  const auto model = Model(SmallOptions());
  const auto message = [&](const TriangleMesh& mesh) { return MessageOf([&] { PoissonNetEvaluator(model, mesh); }); };
  EXPECT_THAT(message(test::Join(Surface(), test::Icosphere(1))), HasSubstr("component"));
  EXPECT_THAT(message(test::MoebiusStrip(12, 3)), HasSubstr("wound in opposite senses"));
  TriangleMesh broken = Surface();
  broken.Points(broken.Triangles(0, 0), 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(broken), HasSubstr("finite"));
  // Valid in double, and without extent in single precision.
  EXPECT_THAT(message(test::Translated(test::Scaled(test::Icosphere(2), 1e-3), { 1e6, 0, 0 })),
    HasSubstr("degenerate in single precision"));
}

TEST(PoissonNetEvaluator, InputsOfTheWrongShapeAreNamed)
{
  PoissonNetOptions options = SmallOptions();
  options.ExtraFeatures = 2;
  const PoissonNetEvaluator evaluator(Model(options), Surface());
  PoissonNetInput input;
  EXPECT_THAT(MessageOf([&] { evaluator.Evaluate(input); }), HasSubstr("extra features are [0, 0]"));
  input.Extra = RandomFeatures(2, 2, 1);
  EXPECT_THAT(MessageOf([&] { evaluator.Evaluate(input); }), HasSubstr("extra features are [2, 2]"));
  input.Extra = RandomFeatures(1, 2, 1);
  EXPECT_EQ(MessageOf([&] { evaluator.Evaluate(input); }), "accepted");
  input.Signal = RandomFeatures(5, 3, 1);
  EXPECT_THAT(MessageOf([&] { evaluator.Evaluate(input); }), HasSubstr("signal is [5, 3]"));
  input.Signal = RandomFeatures(Surface().NumberOfPoints(), 3, 1);
  input.Signal(3, 1) = std::numeric_limits<float>::infinity();
  EXPECT_THAT(MessageOf([&] { evaluator.Evaluate(input); }), HasSubstr("not finite"));
  input.Signal(3, 1) = 1e38F;
  EXPECT_THAT(MessageOf([&] { evaluator.Evaluate(input); }), HasSubstr("not finite"));
  options.Head = PoissonNetHead::Linear;
  options.InputChannels = 5;
  EXPECT_THAT(MessageOf([&] {
    PoissonNetEvaluator(Model(options), Surface()).Evaluate({ {}, RandomFeatures(1, 2, 1) });
  }),
    HasSubstr("takes 5 channels"));
}

TEST(PoissonNetEvaluator, IncompleteModelsAreNamed)
{
  PoissonNetModel model = test::RandomModel(SmallOptions());
  model.Tensors.erase("proj_in.bias");
  const std::string message = MessageOf([&] { EvaluatePoissonNet(model, Surface()); });
  EXPECT_THAT(message, HasSubstr("\"proj_in.bias\" [20] is missing"));
  EXPECT_THROW(MakePoissonNet(model), InvalidInput);
}

TEST(PoissonNetEvaluator, ProgressRisesToOneAndCanStop)
{
  const PoissonNetEvaluator evaluator(Model(SmallOptions()), Surface());
  std::vector<double> reports;
  evaluator.Evaluate({}, [&](double fraction) {
    reports.push_back(fraction);
    return true;
  });
  EXPECT_GE(reports.size(), 10U);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_EQ(reports.back(), 1.0);
  for (const double stop : { 0.0, 0.3, 0.9 })
  {
    EXPECT_THROW(evaluator.Evaluate({}, [stop](double fraction) { return fraction < stop; }), Cancelled);
  }
  EXPECT_TRUE(evaluator.Evaluate().Values.allFinite());
}

TEST(PoissonNetEvaluator, LabelsAreTheLargestChannels)
{
  PoissonNetPrediction prediction;
  prediction.Values.resize(3, 3);
  prediction.Values << -1.0F, -0.5F, -2.0F, -0.1F, -0.1F, -3.0F, -5.0F, -4.0F, -0.2F;
  EXPECT_THAT(prediction.Labels(), ElementsAre(1, 0, 2));
}
