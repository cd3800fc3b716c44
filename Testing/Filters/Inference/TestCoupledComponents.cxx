// SPDX-License-Identifier: BSD-3-Clause
// Networks and flows on bodies of several components.
#include "ExampleMeshes.h"
#include "RandomFlowMatching.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::HasSubstr;

namespace
{
TriangleMesh Body() { return test::BumpySurface(3); }
TriangleMesh Eye()
{
  // Under the surface of the body, which has bumps.
  return test::Translated(test::Icosphere(2, 0.2), 0.75 * Body().Points.row(0).transpose());
}

TriangleMesh BodyWithEye() { return test::Join(Body(), Eye()); }
TriangleMesh EyeWithBody() { return test::Join(Eye(), Body()); }

ComponentCoupling Coupled()
{
  ComponentCoupling coupling;
  coupling.IsOn = true;
  coupling.Distance = 0.3;
  return coupling;
}

std::shared_ptr<const FlowMatchingModel> Model(FlowPrediction prediction)
{
  FlowMatchingModel model = test::RandomDeformer(Body());
  model.Prediction = prediction;
  model.DataDeviation = 2.0;
  return std::make_shared<const FlowMatchingModel>(std::move(model));
}

FlowSampleRequest Request(std::uint32_t sample = 0)
{
  FlowSampleRequest request;
  request.Sample = sample;
  request.Steps = 6;
  return request;
}

Eigen::MatrixXd Positions(const FlowMatchingSampler& sampler, FeatureMatrix noise, const FlowSampleRequest& request)
{
  return sampler.ToSignal(sampler.Integrate(std::move(noise), request));
}

/// Mean offset of the eye from where its places on the body are, against that of the source, over the root of the area.
double OffsetOfEye(const Eigen::MatrixXd& positions)
{
  const TriangleMesh mesh = BodyWithEye();
  const MeshTopology topology(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh, topology);
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double weight = 0.0;
  const Eigen::MatrixXd moved = positions - mesh.Points;
  for (const CoupledPair& pair : FindCoupledPairs(mesh, ComputeComponents(topology, mass), Coupled()))
  {
    const double sign = pair.Vertex < Body().NumberOfPoints() ? -1.0 : 1.0;
    Eigen::RowVector3d difference = moved.row(pair.Vertex);
    for (int k = 0; k < 3; ++k)
    {
      difference -= pair.Weights[k] * moved.row(pair.Corners[k]);
    }
    sum += sign * mass[pair.Vertex] * difference;
    weight += mass[pair.Vertex];
  }
  return sum.norm() / weight / std::sqrt(mass.sum());
}
} // namespace

class CoupledFlow : public testing::TestWithParam<FlowPrediction>
{};

INSTANTIATE_TEST_SUITE_P(Predictions, CoupledFlow,
  testing::Values(FlowPrediction::Velocity, FlowPrediction::Data, FlowPrediction::Preconditioned));

TEST_P(CoupledFlow, KeepsTheOffsetOfAnEyeOverSamples)
{
  const TriangleMesh mesh = BodyWithEye();
  const FlowMatchingSampler sampler(Model(GetParam()), mesh, nullptr, {}, Coupled());
  double moved = 0.0;
  double largest = 0.0;
  for (std::uint32_t k = 0; k < 8; ++k)
  {
    const Eigen::MatrixXd positions = Positions(sampler, sampler.InitialNoise(Request(k)), Request(k));
    largest = std::max(largest, OffsetOfEye(positions));
    moved = std::max(moved, (positions - mesh.Points).rowwise().norm().maxCoeff());
  }
  EXPECT_LT(largest, 0.005); // half a percent of the root of the area
  EXPECT_GT(moved, 0.05);    // of a body that moves
}

TEST_P(CoupledFlow, LosesTheEyeWithoutAWeight)
{
  ComponentCoupling weak = Coupled();
  weak.Weight = 1e-12; // far below the shift of the Poisson equation
  const FlowMatchingSampler sampler(Model(GetParam()), BodyWithEye(), nullptr, {}, weak);
  EXPECT_GT(
    OffsetOfEye(Positions(sampler, sampler.InitialNoise(Request()), Request())), 0.005); // beyond the limit above
}

TEST_P(CoupledFlow, DoesNotDependOnTheOrderOfComponents)
{
  const TriangleMesh first = BodyWithEye(), second = EyeWithBody();
  const Index body = Body().NumberOfPoints(), eye = Eye().NumberOfPoints();
  const FlowMatchingSampler a(Model(GetParam()), first, nullptr, {}, Coupled());
  const FlowMatchingSampler b(Model(GetParam()), second, nullptr, {}, Coupled());
  const FeatureMatrix noise = a.InitialNoise(Request());
  FeatureMatrix other(noise.rows(), noise.cols());
  other << noise.bottomRows(eye), noise.topRows(body);
  const Eigen::MatrixXd p = Positions(a, noise, Request()), q = Positions(b, other, Request());
  EXPECT_LT((p.topRows(body) - q.bottomRows(body)).norm(), 1e-5 * p.norm());
  EXPECT_LT((p.bottomRows(eye) - q.topRows(eye)).norm(), 1e-5 * p.norm());
}

TEST_P(CoupledFlow, OfOneComponentHasTheSameBits)
{
  const FlowMatchingSampler with(Model(GetParam()), Body(), nullptr, {}, Coupled());
  const FlowMatchingSampler without(Model(GetParam()), Body());
  EXPECT_TRUE(with.InitialNoise(Request()) == without.InitialNoise(Request()));
  EXPECT_TRUE(Positions(with, with.InitialNoise(Request()), Request()) ==
    Positions(without, without.InitialNoise(Request()), Request()));
}

TEST(CoupledFlow, TakesSeveralComponentsOnlyCoupled)
{
  const auto model = Model(FlowPrediction::Data);
  EXPECT_THAT(MessageOf([&] { FlowMatchingSampler(model, BodyWithEye()); }),
    HasSubstr("2 connected components where one is needed"));
  ComponentCoupling near = Coupled();
  near.Distance = 1e-6;
  EXPECT_THAT(MessageOf([&] { FlowMatchingSampler(model, BodyWithEye(), nullptr, {}, near); }),
    HasSubstr("farther than the coupling distance"));
}

TEST(CoupledNetwork, RefusesACoupledSignalOfTheWrongShape)
{
  const auto model = Model(FlowPrediction::Data);
  const PoissonNetEvaluator network(
    std::shared_ptr<const PoissonNetModel>(model, &model->Velocity), BodyWithEye(), nullptr, {}, Coupled());
  PoissonNetInput input;
  input.Extra = FeatureMatrix::Zero(1, model->Velocity.Options.ExtraFeatures);
  input.CoupledSignal = FeatureMatrix::Zero(5, 3);
  EXPECT_THAT(MessageOf([&] { network.Evaluate(input); }), HasSubstr("the coupled signal is [5, 3]"));
}
