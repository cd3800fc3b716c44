// SPDX-License-Identifier: BSD-3-Clause
// The plain sampler of flow matching models: integrators, units, invariances, errors.
#include "ExampleMeshes.h"
#include "InstructionSets.h"
#include "RandomFlowMatching.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/UsedPoints.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{

const TriangleMesh& Surface()
{
  static const TriangleMesh mesh = test::BumpySurface(2);
  return mesh;
}

std::shared_ptr<const FlowMatchingModel> Shared(FlowMatchingModel model)
{
  return std::make_shared<const FlowMatchingModel>(std::move(model));
}

FlowMatchingSampler Deformer(const TriangleMesh& mesh = Surface())
{
  return FlowMatchingSampler(Shared(test::RandomDeformer(Surface())), mesh);
}

FlowMatchingSampler SignalSampler(std::int64_t components)
{
  return FlowMatchingSampler(Shared(test::RandomSignalModel(Surface(), components)), Surface());
}

FlowSampleRequest Request(int steps, FlowIntegrator integrator = FlowIntegrator::Midpoint)
{
  FlowSampleRequest request;
  request.Steps = steps;
  request.Integrator = integrator;
  return request;
}

FeatureMatrix Sampled(const FlowMatchingSampler& sampler, const FlowSampleRequest& request)
{
  return sampler.Integrate(sampler.InitialNoise(request), request);
}

bool SameBits(const FeatureMatrix& a, const FeatureMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() &&
    std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(float)) == 0;
}

double Difference(const FeatureMatrix& a, const FeatureMatrix& b)
{
  return (a - b).cast<double>().norm() / b.cast<double>().norm();
}

/// Largest difference of velocities of a model with this prediction from the way to the data of its definition, with the output
/// of the network from a model of the same weights whose velocity it is.
double ErrorOfVelocity(FlowPrediction prediction, FlowMatchingModel model, bool positions, double time)
{
  const FlowMatchingSampler network(Shared(model), Surface());
  model.Prediction = prediction;
  model.DataDeviation = 0.2;
  const FlowMatchingSampler sampler(Shared(model), Surface());
  const FeatureMatrix state = sampler.InitialNoise(Request(1));
  const auto t = static_cast<float>(time);
  const FeatureMatrix source = positions ? sampler.FromDeviation(Surface().Points)
                                         : FeatureMatrix::Zero(state.rows(), state.cols());
  const FeatureMatrix input = (state - t * source) / (0.2F * std::hypot(1.0F - t, t));
  const FeatureMatrix output = network.Velocity(input, time);
  const FeatureMatrix predicted = positions ? FeatureMatrix(output - input) : output;
  if (prediction == FlowPrediction::Data)
  {
    const FeatureMatrix expected = (source + 0.2F * predicted - state) / std::max(1.0F - t, 0.02F);
    return Difference(sampler.Velocity(state, time), expected);
  }
  const FeatureMatrix data = source + 0.2F / std::hypot(1.0F - t, t) * (t * input + (1.0F - t) * predicted);
  return Difference((1.0F - t) * sampler.Velocity(state, time), data - state);
}

/// A part of the bumpy surface: its triangles with their centroid on the left. The points that it has in the whole.
struct Part
{
  TriangleMesh Mesh;
  std::vector<Index> Points;
  MeshNormalization Whole; ///< normalization of the whole surface
};

Part LeftOf(const TriangleMesh& whole)
{
  TriangleMesh left = whole;
  Index kept = 0;
  for (Index f = 0; f < whole.NumberOfTriangles(); ++f)
  {
    const auto corners = whole.Triangles.row(f).eval();
    if (whole.Points(corners(0), 0) + whole.Points(corners(1), 0) + whole.Points(corners(2), 0) <
      3.0 * FlowNormalization(whole).Center[0])
    {
      left.Triangles.row(kept++) = corners;
    }
  }
  left.Triangles.conservativeResize(kept, 3);
  const UsedPoints used(left);
  Part part{ used.Compact(left), {}, FlowNormalization(whole) };
  for (Index k = 0; k < part.Mesh.NumberOfPoints(); ++k)
  {
    part.Points.push_back(used.Id(k));
  }
  return part;
}

FlowMatchingSampler SamplerOfPart(FlowMatchingModel model, const Part& part)
{
  return FlowMatchingSampler(Shared(std::move(model)), part.Mesh, nullptr, {}, {}, part.Whole);
}

Eigen::RowVectorXd MeanOf(const TriangleMesh& mesh, const Eigen::MatrixXd& values)
{
  const Eigen::VectorXd mass = LumpedMass(mesh);
  return mass.transpose() * values / mass.sum();
}

/// The Euler, midpoint and classical Runge-Kutta step from @p state at @p time, as their definitions say.
FeatureMatrix StepOf(
  const FlowMatchingSampler& sampler, FlowIntegrator integrator, const FeatureMatrix& state, double time, double step)
{
  const auto h = static_cast<float>(step);
  const FeatureMatrix a = sampler.Velocity(state, time);
  if (integrator == FlowIntegrator::Euler)
  {
    return state + h * a;
  }
  const FeatureMatrix b = sampler.Velocity(state + h / 2 * a, time + step / 2);
  if (integrator == FlowIntegrator::Midpoint)
  {
    return state + h * b;
  }
  const FeatureMatrix c = sampler.Velocity(state + h / 2 * b, time + step / 2);
  const FeatureMatrix d = sampler.Velocity(state + h * c, time + step);
  return state + h / 6 * (a + 2 * b + 2 * c + d);
}

constexpr FlowIntegrator Integrators[] = { FlowIntegrator::Euler, FlowIntegrator::Midpoint,
  FlowIntegrator::RungeKutta4 };

} // namespace

// --- Integration ----------------------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, VelocitiesLeadToThePredictedData)
{
  for (const double time : { 0.0, 0.3, 0.97, 0.99, 1.0 })
  {
    const FlowPrediction data = FlowPrediction::Data;
    EXPECT_LT(ErrorOfVelocity(data, test::RandomDeformer(Surface()), true, time), 1e-4) << time;
    EXPECT_LT(ErrorOfVelocity(data, test::RandomSignalModel(Surface(), 2), false, time), 1e-4) << time;
  }
}

// Single precision leaves 1e-7 of the state in the difference of the data from it, which shrinks as 1 - t.
TEST(FlowMatchingSampler, VelocitiesOfPreconditionedPredictionsLeadToTheData)
{
  for (const double time : { 0.0, 0.3, 0.5, 0.8, 0.95 })
  {
    const FlowPrediction prediction = FlowPrediction::Preconditioned;
    EXPECT_LT(ErrorOfVelocity(prediction, test::RandomDeformer(Surface()), true, time), 1e-4) << time;
    EXPECT_LT(ErrorOfVelocity(prediction, test::RandomSignalModel(Surface(), 2), false, time), 1e-4) << time;
  }
}

TEST(FlowMatchingSampler, IntegratorsTakeTheStepsOfTheirDefinitions)
{
  const FlowMatchingSampler sampler = SignalSampler(2);
  for (const FlowIntegrator integrator : Integrators)
  {
    const FeatureMatrix noise = sampler.InitialNoise({});
    FeatureMatrix expected = noise;
    for (int k = 0; k < 4; ++k)
    {
      expected = StepOf(sampler, integrator, expected, 0.25 * k, 0.25);
    }
    EXPECT_LE(Difference(sampler.Integrate(noise, Request(4, integrator)), expected), 1e-6);
  }
}

// The error against a fine reference falls as h^order; between 8 and 16 steps rounding is far below it for the first
// two, and the fourth order reaches rounding at once.
TEST(FlowMatchingSampler, IntegratorsConvergeAtTheirOrder)
{
  const FlowMatchingSampler sampler = SignalSampler(2);
  const FeatureMatrix reference = Sampled(sampler, Request(128, FlowIntegrator::RungeKutta4));
  const auto error = [&](int steps, FlowIntegrator integrator) {
    return Difference(Sampled(sampler, Request(steps, integrator)), reference);
  };
  const double euler = std::log2(error(8, FlowIntegrator::Euler) / error(16, FlowIntegrator::Euler));
  EXPECT_NEAR(euler, 1.0, 0.15);
  const double midpoint = std::log2(error(4, FlowIntegrator::Midpoint) / error(8, FlowIntegrator::Midpoint));
  EXPECT_NEAR(midpoint, 2.0, 0.3);
  const double rungeKutta = std::log2(error(1, FlowIntegrator::RungeKutta4) / error(2, FlowIntegrator::RungeKutta4));
  EXPECT_NEAR(rungeKutta, 4.0, 0.8);
  EXPECT_LT(error(8, FlowIntegrator::RungeKutta4), error(8, FlowIntegrator::Midpoint) / 10.0);
}

// f <- t f + (1 - t) v(t f, t), one after another, for both kinds of model; only the state at the end is corrected.
TEST(FlowMatchingSampler, CorrectionsAreTheDataThatTheModelExpectsFromTheEndOfTheFlow)
{
  EXPECT_DOUBLE_EQ(CorrectionTime(0, 1), 0.75);
  EXPECT_DOUBLE_EQ(CorrectionTime(0, 3), 0.625);
  EXPECT_DOUBLE_EQ(CorrectionTime(2, 3), 0.875);
  FlowMatchingModel model = test::RandomDeformer(Surface());
  for (const FlowPrediction prediction :
    { FlowPrediction::Velocity, FlowPrediction::Data, FlowPrediction::Preconditioned })
  {
    model.Prediction = prediction;
    EXPECT_EQ(SuitableCorrections(model), prediction == FlowPrediction::Data ? 2 : 0);
    const FlowMatchingSampler sampler(Shared(model), Surface());
    FlowSampleRequest request = Request(3);
    const FeatureMatrix flow = Sampled(sampler, request);
    FeatureMatrix expected = flow;
    for (const float time : { 2.0F / 3.0F, 5.0F / 6.0F })
    {
      const FeatureMatrix state = time * expected;
      expected = state + (1.0F - time) * sampler.Velocity(state, time);
    }
    request.Corrections = 2;
    std::vector<FeatureMatrix> states;
    sampler.Integrate(
      sampler.InitialNoise(request), request, [&](double, const FeatureMatrix& state) { states.push_back(state); });
    ASSERT_EQ(states.size(), 4U);
    EXPECT_LE(Difference(states.back(), expected), 1e-6);
    EXPECT_GT(Difference(states.back(), flow), 1e-3);
  }
}

// The temperature is a factor of the noise; 1 keeps its bits, and 0 leaves nothing of it.
TEST(FlowMatchingSampler, TheTemperatureScalesTheNoise)
{
  const FlowMatchingSampler sampler = Deformer();
  FlowSampleRequest request = Request(2);
  const FeatureMatrix noise = sampler.InitialNoise(request);
  request.Temperature = 1.5;
  EXPECT_LE(Difference(sampler.InitialNoise(request), 1.5F * noise), 1e-5);
  EXPECT_GT(Difference(sampler.InitialNoise(request), noise), 1e-2);
  request.Temperature = 0.0;
  EXPECT_EQ(sampler.InitialNoise(request).cwiseAbs().maxCoeff(), 0.0F);
  EXPECT_TRUE(Sampled(sampler, request).allFinite());
  FlowMatchingModel warm = sampler.Model();
  warm.Temperature = 1.2;
  request.Temperature = 1.5;
  EXPECT_LE(Difference(FlowMatchingSampler(Shared(warm), Surface()).InitialNoise(request), 1.8F * noise), 1e-5)
    << "that of the model is a factor, too";
}

TEST(FlowMatchingSampler, TheObserverSeesTheStateAfterEachStep)
{
  const FlowMatchingSampler sampler = Deformer();
  const FeatureMatrix noise = sampler.InitialNoise({});
  for (const FlowIntegrator integrator : Integrators)
  {
    std::vector<double> times;
    std::vector<FeatureMatrix> states;
    const FeatureMatrix end = sampler.Integrate(
      noise, Request(4, integrator), [&](double time, const FeatureMatrix& state) {
        times.push_back(time);
        states.push_back(state);
      });
    EXPECT_THAT(times, ElementsAre(0.0, 0.25, 0.5, 0.75, 1.0));
    EXPECT_TRUE(SameBits(states.front(), noise));
    EXPECT_TRUE(SameBits(states.back(), end));
    EXPECT_LE(Difference(states[2], StepOf(sampler, integrator, states[1], 0.25, 0.25)), 1e-6);
    EXPECT_GT(Difference(states[2], states[1]), 1e-3) << "something moves";
  }
}

TEST(FlowMatchingSampler, EvaluationsAreThoseOfTheIntegrator)
{
  EXPECT_EQ(EvaluationsPerStep(FlowIntegrator::Euler), 1);
  EXPECT_EQ(EvaluationsPerStep(FlowIntegrator::Midpoint), 2);
  EXPECT_EQ(EvaluationsPerStep(FlowIntegrator::RungeKutta4), 4);
}

// --- What a sample depends on ---------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, BitsAreTheSameForEveryNumberOfThreads)
{
  std::unique_ptr<FeatureMatrix> first;
  for (const int threads : { 1, 2, 3 })
  {
    const ThreadScope scope(threads);
    const FeatureMatrix sample = Sampled(Deformer(), Request(3));
    first = first ? std::move(first) : std::make_unique<FeatureMatrix>(sample);
    EXPECT_TRUE(SameBits(sample, *first)) << threads;
  }
}

// Noise, solves and a network of random weights, from the noise to the sample.
TEST(FlowMatchingSampler, InstructionSetsAgree)
{
  FeatureMatrix noise;
  FeatureMatrix sample;
  test::ForEachInstructionSet([&](InstructionSet set) {
    const FlowMatchingSampler sampler = Deformer();
    const FeatureMatrix initial = sampler.InitialNoise({});
    const FeatureMatrix found = sampler.Integrate(initial, Request(3));
    if (set == InstructionSet::Generic)
    {
      noise = initial;
      sample = found;
    }
    EXPECT_LE(Difference(initial, noise), 1e-6) << static_cast<int>(set);
    EXPECT_LE(Difference(found, sample), 1e-5) << static_cast<int>(set);
  });
}

TEST(FlowMatchingSampler, SeedSampleAndStreamGiveOtherNoise)
{
  const FlowMatchingSampler sampler = Deformer();
  const FeatureMatrix noise = sampler.InitialNoise({});
  EXPECT_TRUE(SameBits(sampler.InitialNoise(Request(7, FlowIntegrator::Euler)), noise)) << "steps do not matter";
  FlowSampleRequest seed;
  seed.Seed = 1;
  FlowSampleRequest sample;
  sample.Sample = 1;
  FlowSampleRequest stream;
  stream.Stream = 1;
  for (const FlowSampleRequest& other : { seed, sample, stream })
  {
    EXPECT_GT(Difference(sampler.InitialNoise(other), noise), 0.5);
  }
}

TEST(FlowMatchingSampler, PositionsCommuteWithTranslationAndUniformScale)
{
  const FlowMatchingSampler here = Deformer();
  const Eigen::MatrixXd expected = here.ToSignal(Sampled(here, Request(4)));
  const double size = test::BumpySurface(2).Points.rowwise().norm().maxCoeff();
  for (const double factor : { 1e-6, 100.0 })
  {
    const Eigen::Vector3d offset = factor * Eigen::Vector3d(3.0, -2.0, 1.0);
    const FlowMatchingSampler there = Deformer(test::Translated(test::Scaled(Surface(), factor), offset));
    const Eigen::MatrixXd found = there.ToSignal(Sampled(there, Request(4)));
    const Eigen::MatrixXd difference = (found.rowwise() - offset.transpose()) / factor - expected;
    EXPECT_LE(difference.cwiseAbs().maxCoeff() / size, 1e-4) << factor;
  }
}

TEST(FlowMatchingSampler, AnEncoderReachesTheVelocity)
{
  FlowMatchingModel model = test::RandomSignalModel(Surface(), 2);
  test::AddRandomEncoder(model, 5);
  const FeatureMatrix state = FeatureMatrix::Zero(Surface().NumberOfPoints(), 2);
  const FlowMatchingSampler sampler(Shared(model), Surface());
  const TriangleMesh normalized = Normalized(Surface(), FlowNormalization(Surface()));
  const PoissonNetEvaluator encoder(std::make_shared<const PoissonNetModel>(*model.Encoder), normalized);
  const PoissonNetEvaluator velocity(
    std::make_shared<const PoissonNetModel>(model.Velocity), encoder.Operators(), normalized.Points);
  PoissonNetInput input;
  input.Signal = state;
  input.Extra.resize(state.rows(), 9);
  input.Extra.col(0).setConstant(0.25F);
  input.Extra.middleCols(1, 3) = normalized.Points.cast<float>();
  input.Extra.rightCols(5) = encoder.Evaluate().Values;
  EXPECT_LE(Difference(sampler.Velocity(state, 0.25), velocity.Evaluate(input).Values), 1e-5);
}

// --- Units ----------------------------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, SignalsGetTheMeanAndScaleOfTheTraining)
{
  const FlowMatchingSampler sampler = SignalSampler(2); // mean 2, 3; scale 0.5, 1
  FeatureMatrix state = FeatureMatrix::Zero(Surface().NumberOfPoints(), 2);
  state(3, 0) = 4.0F;
  state(5, 1) = -1.0F;
  const Eigen::MatrixXd signal = sampler.ToSignal(state);
  EXPECT_EQ(signal(3, 0), 4.0);
  EXPECT_EQ(signal(3, 1), 3.0);
  EXPECT_EQ(signal(5, 0), 2.0);
  EXPECT_EQ(signal(5, 1), 2.0);
  const Eigen::MatrixXd deviation = sampler.ToDeviation(state);
  EXPECT_EQ(deviation(3, 0), 2.0);
  EXPECT_EQ(deviation(5, 1), -1.0);
  EXPECT_EQ(deviation(0, 0), 0.0);
}

TEST(FlowMatchingSampler, PositionsAreAboutTheCentroidOfTheSurface)
{
  const TriangleMesh mesh = test::Translated(test::Scaled(Surface(), 3.0), { 5.0, 6.0, 7.0 });
  const FlowMatchingSampler sampler = Deformer(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const auto mean = [&](const Eigen::MatrixXd& values) {
    return Eigen::RowVectorXd(mass.transpose() * values / mass.sum());
  };
  const Eigen::RowVectorXd centroid = mean(mesh.Points);
  const FeatureMatrix noise = sampler.InitialNoise({});
  EXPECT_LE(mean(sampler.ToDeviation(noise)).norm(), 1e-6);
  const FeatureMatrix state = sampler.Integrate(noise, Request(4));
  EXPECT_LE((mean(sampler.ToSignal(state)) - centroid).norm(), 1e-5);
  EXPECT_LE((sampler.ToSignal(state) - sampler.ToDeviation(state)).rowwise().norm().maxCoeff() - centroid.norm(), 1e-9);
}

TEST(FlowMatchingSampler, InitialNoiseIsTheFieldOfTheModel)
{
  FlowMatchingModel model = test::RandomSignalModel(Surface(), 2);
  model.Noise.Screening = 30.0;
  model.Noise.Scale = 2.5;
  const FlowMatchingSampler sampler(Shared(model), Surface());
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  options.Screening = 30.0;
  const MaternField field(Normalized(Surface(), FlowNormalization(Surface())), options);
  SampleRequest request;
  request.Seed = 9;
  request.FirstSample = 4;
  request.NumberOfComponents = 2;
  request.Stream = 6;
  FlowSampleRequest flow;
  flow.Seed = 9;
  flow.Sample = 4;
  flow.Stream = 6;
  EXPECT_LE(Difference(sampler.InitialNoise(flow), FeatureMatrix((2.5 * field.Sample(request)).cast<float>())), 1e-5);
}

// --- Parts of surfaces ------------------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, TheNormalizationOfTheSurfaceItselfChangesNothing)
{
  const MeshNormalization own = FlowNormalization(Surface());
  EXPECT_EQ(FlowNormalization(LumpedMass(Surface()).sum(), own.Center).Scale, std::sqrt(LumpedMass(Surface()).sum()));
  for (const FlowMatchingModel& model : { test::RandomDeformer(Surface()), test::RandomSignalModel(Surface(), 2) })
  {
    const FlowMatchingSampler expected(Shared(model), Surface());
    const FlowMatchingSampler sampler(Shared(model), Surface(), nullptr, {}, {}, own);
    EXPECT_TRUE(SameBits(sampler.InitialNoise({}), expected.InitialNoise({})));
    EXPECT_LE(Difference(Sampled(sampler, Request(3)), Sampled(expected, Request(3))), 1e-5);
  }
}

// A network without its Poisson solves sees each point alone: its condition and state.
TEST(FlowMatchingSampler, PointsOfAPartHaveTheConditionThatTheyHaveInTheWhole)
{
  FlowMatchingModel model = test::RandomSignalModel(Surface(), 2);
  const std::int64_t width = model.Velocity.Options.Width;
  for (const char* block : { "blocks.0", "blocks.1" })
  {
    ModelTensor& first = model.Velocity.Tensors.at(std::string(block) + ".vert_mlp.mlp1.layers.0.weight");
    for (std::int64_t row = 0; row < width; ++row)
    {
      std::fill_n(first.Values.begin() + row * first.Shape[1] + width, width, 0.0F);
    }
  }
  const Part part = LeftOf(Surface());
  const FeatureMatrix state = FeatureMatrix::Ones(Surface().NumberOfPoints(), 2);
  const FeatureMatrix whole = FlowMatchingSampler(Shared(model), Surface()).Velocity(state, 0.3);
  FeatureMatrix expected(part.Mesh.NumberOfPoints(), 2);
  for (Index k = 0; k < part.Mesh.NumberOfPoints(); ++k)
  {
    expected.row(k) = whole.row(part.Points[k]);
  }
  const FeatureMatrix some = state.topRows(part.Mesh.NumberOfPoints());
  EXPECT_LE(Difference(SamplerOfPart(model, part).Velocity(some, 0.3), expected), 1e-5);
  EXPECT_GT(Difference(FlowMatchingSampler(Shared(model), part.Mesh).Velocity(some, 0.3), expected), 1e-3)
    << "by its own area and centroid it is elsewhere";
}

TEST(FlowMatchingSampler, TheMeanOfAPartGoesStraightToThatOfItsSource)
{
  const Part part = LeftOf(test::Translated(test::Scaled(Surface(), 3.0), { 5.0, 6.0, 7.0 }));
  const Eigen::RowVectorXd offset = MeanOf(part.Mesh, part.Mesh.Points) - part.Whole.Center;
  ASSERT_GT(offset.norm(), 0.5);
  for (const FlowPrediction prediction :
    { FlowPrediction::Velocity, FlowPrediction::Data, FlowPrediction::Preconditioned })
  {
    FlowMatchingModel model = test::RandomDeformer(Surface());
    model.Prediction = prediction;
    model.DataDeviation = 0.2;
    const FlowMatchingSampler sampler = SamplerOfPart(model, part);
    const auto follow = [&](double time, const FeatureMatrix& state) {
      EXPECT_LE((MeanOf(part.Mesh, sampler.ToDeviation(state)) - time * offset).norm(), 1e-4)
        << NameOf(prediction) << time;
    };
    FlowSampleRequest request = Request(4);
    request.Corrections = 20;
    const FeatureMatrix state = sampler.Integrate(sampler.InitialNoise({}), request, follow);
    EXPECT_LE((MeanOf(part.Mesh, sampler.ToSignal(state)) - MeanOf(part.Mesh, part.Mesh.Points)).norm(), 1e-4);
  }
}

TEST(FlowMatchingSampler, SamplesOfPartsScaleAndMoveWithTheirWhole)
{
  const Part part = LeftOf(Surface());
  const Part moved = LeftOf(test::Translated(test::Scaled(Surface(), 8.0), { 16.0, -8.0, 4.0 }));
  const FlowMatchingModel model = test::RandomDeformer(Surface());
  const FlowMatchingSampler one = SamplerOfPart(model, part);
  const FlowMatchingSampler other = SamplerOfPart(model, moved);
  const Eigen::MatrixXd found = other.ToDeviation(Sampled(other, Request(3)));
  const Eigen::MatrixXd expected = 8.0 * one.ToDeviation(Sampled(one, Request(3)));
  EXPECT_LE((found - expected).norm(), 1e-4 * expected.norm());
}

TEST(FlowMatchingSampler, PartsAreWarnedOfOnlyBeyondTheirWhole)
{
  const Part part = LeftOf(Surface());
  const FlowMatchingModel model = test::RandomDeformer(Surface());
  const auto warnings = [&](const MeshNormalization& whole) {
    return FlowMatchingSampler(Shared(model), part.Mesh, nullptr, {}, {}, whole).Warnings();
  };
  EXPECT_THAT(warnings(part.Whole), IsEmpty());
  EXPECT_THAT(FlowMatchingSampler(Shared(model), part.Mesh).Warnings(), ElementsAre(HasSubstr("shaped or turned")));
  const double area = part.Whole.Scale * part.Whole.Scale;
  EXPECT_THAT(warnings(FlowNormalization(0.2 * area, part.Whole.Center)),
    ElementsAre(AllOf(HasSubstr("no part"), HasSubstr("second moments"))));
  EXPECT_THAT(warnings(FlowNormalization(area, part.Whole.Center + Eigen::RowVector3d(9.0, 0.0, 0.0))),
    ElementsAre(HasSubstr("no part")));
}

TEST(FlowMatchingSampler, NormalizationsOfNothingAreErrors)
{
  const Eigen::RowVector3d origin = Eigen::RowVector3d::Zero();
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double area : { 0.0, -1.0, infinite, std::nan("") })
  {
    EXPECT_THAT(MessageOf([&] { FlowNormalization(area, origin); }), HasSubstr("expected a finite area above 0"));
  }
  EXPECT_THAT(MessageOf([&] { FlowNormalization(1.0, { 0.0, infinite, 0.0 }); }), HasSubstr("the center (0, inf, 0)"));
}

// --- Warnings -------------------------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, AnotherTriangulationOfTheShapeIsNoWarning)
{
  for (const TriangleMesh& mesh :
    { Surface(), test::Subdivide(Surface()), test::RefineToSize(Surface(), 600), test::Scaled(Surface(), 40.0) })
  {
    EXPECT_THAT(Deformer(mesh).Warnings(), IsEmpty());
  }
}

TEST(FlowMatchingSampler, AnotherShapeAndATurnedOneAreWarnings)
{
  const auto warnings = [](const FlowMatchingModel& model, const TriangleMesh& mesh) {
    return FlowMatchingSampler(Shared(model), mesh).Warnings();
  };
  const TriangleMesh torus = test::Torus(16, 10);
  const FlowMatchingModel model = test::RandomDeformer(torus);
  EXPECT_THAT(warnings(model, torus), IsEmpty());
  TriangleMesh turned = torus;
  turned.Points.col(1).swap(turned.Points.col(2));
  turned.Points.col(1) *= -1.0;
  EXPECT_THAT(warnings(model, turned), ElementsAre(AllOf(HasSubstr("turned"), HasSubstr("second moments"))));
  EXPECT_THAT(warnings(model, test::Icosphere(2)), ElementsAre(HasSubstr("shaped or turned unlike")));
  TriangleMesh inwards = torus;
  inwards.Triangles.col(0).swap(inwards.Triangles.col(1));
  EXPECT_THAT(warnings(model, inwards), ElementsAre(HasSubstr("point inwards")));
  FlowMatchingModel tolerant = model;
  tolerant.Shape.Spread = 2.0;
  EXPECT_THAT(warnings(tolerant, turned), IsEmpty()) << "its training surfaces differed as much";
}

// --- Errors ---------------------------------------------------------------------------------------------------------

TEST(FlowMatchingSampler, WhatCannotBeSampledIsNamed)
{
  const FlowMatchingSampler sampler = Deformer();
  const FeatureMatrix noise = sampler.InitialNoise({});
  EXPECT_THAT(MessageOf([&] { sampler.Integrate(noise, Request(0)); }), HasSubstr("0 steps; expected at least 1"));
  for (const int wrong : { -1, 21 })
  {
    FlowSampleRequest request = Request(2);
    request.Corrections = wrong;
    EXPECT_THAT(MessageOf([&] { sampler.Integrate(noise, request); }),
      HasSubstr(std::to_string(wrong) + " corrections; expected 0 to 20"));
  }
  for (const double wrong : { -0.5, std::numeric_limits<double>::infinity(), std::nan("") })
  {
    FlowSampleRequest request = Request(2);
    request.Temperature = wrong;
    EXPECT_THAT(MessageOf([&] { sampler.InitialNoise(request); }), HasSubstr("expected a finite number, at least 0"));
  }
  EXPECT_THAT(MessageOf([&] { sampler.Integrate(noise.topRows(5), Request(2)); }), HasSubstr("signal is [5, 3]"));
  EXPECT_THAT(MessageOf([&] { Deformer(test::Join(Surface(), Surface())); }), HasSubstr("component"));
  EXPECT_THAT(MessageOf([&] { Deformer(test::MoebiusStrip(12, 3)); }), HasSubstr("wound in opposite senses"));
  FlowMatchingModel incomplete = test::RandomDeformer(Surface());
  incomplete.Velocity.Tensors.erase("proj_in.bias");
  EXPECT_THAT(MessageOf([&] { FlowMatchingSampler(Shared(incomplete), Surface()); }), HasSubstr("proj_in.bias"));
}

TEST(FlowMatchingSampler, AStateThatGrowsWithoutBoundIsAnError)
{
  FlowMatchingModel model = test::RandomSignalModel(Surface(), 1);
  model.Velocity.Tensors["head.bias"].Values = { 1e7F };
  const FlowMatchingSampler sampler(Shared(model), Surface());
  EXPECT_THAT(MessageOf([&] { Sampled(sampler, Request(3)); }), HasSubstr("grows without bound at flow time"));
  model.Velocity.Tensors["head.bias"].Values = { 3e38F };
  const float large = model.Velocity.Tensors["proj_in.bias"].Values.front();
  model.Velocity.Tensors["proj_in.bias"].Values.front() = large + 1e38F;
  const FlowMatchingSampler overflowing(Shared(model), Surface());
  EXPECT_THAT(MessageOf([&] { overflowing.Velocity(overflowing.InitialNoise({}), 0.0); }), HasSubstr("is not finite"));
  EXPECT_THAT(MessageOf([&] { Sampled(overflowing, Request(3)); }), HasSubstr("grows without bound at flow time 0"))
    << "also where the network's output overflows before the state is beyond its limit";
}

TEST(FlowMatchingSampler, ProgressRisesAndCanStop)
{
  const FlowMatchingSampler sampler = Deformer();
  const FeatureMatrix noise = sampler.InitialNoise({});
  std::vector<double> reports;
  FlowSampleRequest request = Request(3);
  request.Corrections = 2;
  sampler.Integrate(noise, request, {}, [&](double fraction) {
    reports.push_back(fraction);
    return true;
  });
  EXPECT_GE(reports.size(), 30U);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_NEAR(reports.back(), 1.0, 1e-12);
  for (const double stop : { 0.0, 0.4, 0.9 })
  {
    EXPECT_THROW(sampler.Integrate(noise, request, {}, [stop](double fraction) { return fraction < stop; }), Cancelled);
    EXPECT_THROW(FlowMatchingSampler(Shared(test::RandomDeformer(Surface())), Surface(), nullptr,
                   [stop](double fraction) { return fraction < stop; }),
      Cancelled);
  }
}
