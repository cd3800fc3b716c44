// SPDX-License-Identifier: BSD-3-Clause
// Networks and flows on bodies of several components.
#include "ExampleMeshes.h"
#include "RandomFlowMatching.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Inference/FlowMatching/CoupledOffsets.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

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
  if (prediction == FlowPrediction::Velocity)
  {
    // Velocities of a random network turn surfaces inside out, which leaves no rotation to find.
    for (const char* name : { "head.grad_mlp.layers.1.lin_real.weight", "head.grad_mlp.layers.1.lin_imag.weight" })
    {
      for (float& weight : model.Velocity.Tensors.at(name).Values)
      {
        weight *= 0.05F;
      }
    }
  }
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

/// Mean offset of the eye from where its places on the body are, against that of the source turned as these places are,
/// over the root of the area.
double OffsetOfEye(const Eigen::MatrixXd& positions)
{
  const TriangleMesh mesh = BodyWithEye();
  const MeshTopology topology(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh, topology);
  const auto pairs = FindCoupledPairs(mesh, ComputeComponents(topology, mass), Coupled());
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const Index pointsOfBody = Body().NumberOfPoints();
  const auto ends = [&](const Eigen::MatrixXd& values) {
    PointMatrix onBody(count, 3), onEye(count, 3);
    for (Eigen::Index k = 0; k < count; ++k)
    {
      const CoupledPair& pair = pairs[static_cast<std::size_t>(k)];
      Eigen::RowVector3d far = Eigen::RowVector3d::Zero();
      for (int i = 0; i < 3; ++i)
      {
        far += pair.Weights[i] * values.row(pair.Corners[i]);
      }
      const bool isBody = pair.Vertex < pointsOfBody;
      onBody.row(k) = isBody ? Eigen::RowVector3d(values.row(pair.Vertex)) : far;
      onEye.row(k) = isBody ? far : Eigen::RowVector3d(values.row(pair.Vertex));
    }
    return std::pair(onBody, onEye);
  };
  const auto [restBody, restEye] = ends(mesh.Points);
  const auto [body, eye] = ends(positions);
  const Eigen::Matrix4d motion = Eigen::umeyama(restBody.transpose(), body.transpose(), false);
  const PointMatrix offsets = eye - body - (restEye - restBody) * motion.topLeftCorner<3, 3>().transpose();
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double weight = 0.0;
  for (Eigen::Index k = 0; k < count; ++k)
  {
    const double m = mass[pairs[static_cast<std::size_t>(k)].Vertex];
    sum += m * offsets.row(k);
    weight += m;
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
    FeatureMatrix noise = sampler.InitialNoise(Request(k));
    if (GetParam() == FlowPrediction::Velocity)
    {
      // They do not remove the noise either: the flow begins near the surface.
      noise = 0.1F * noise + Normalized(mesh, FlowNormalization(mesh)).Points.cast<float>();
    }
    const Eigen::MatrixXd positions = Positions(sampler, std::move(noise), Request(k));
    largest = std::max(largest, OffsetOfEye(positions));
    moved = std::max(moved, (positions - mesh.Points).rowwise().norm().maxCoeff());
  }
  EXPECT_LT(largest, 0.005); // half a percent of the root of the area
  EXPECT_GT(moved, 0.05);    // of a body that moves
}

TEST_P(CoupledFlow, EndsWithOffsetsThatTurnWithTheBody)
{
  const TriangleMesh mesh = BodyWithEye();
  const auto model = Model(GetParam());
  const FlowMatchingSampler sampler(model, mesh, nullptr, {}, Coupled());
  const MeshNormalization normalization = FlowNormalization(mesh);
  const TriangleMesh source = Normalized(mesh, normalization);
  const ComponentCoupling coupling = ScaledCoupling(Coupled(), normalization);
  const MeshTopology topology(source);
  const PoissonShift shift = model->Velocity.Options.Shift;
  const PoissonOperators operators = BuildPoissonOperators(source, topology, {}, shift, coupling);
  const CoupledOffsets offsets(source, topology, coupling, operators.Solver);
  FlowSampleRequest request = Request();
  request.Steps = 1;
  request.Integrator = FlowIntegrator::Euler;
  for (request.Sample = 0; request.Sample < 4; ++request.Sample)
  {
    const FeatureMatrix noise = 2.0F * sampler.InitialNoise(request);
    const PointMatrix flown = (noise + sampler.Velocity(noise, 0.0)).cast<double>();
    PointMatrix expected = flown;
    offsets.Restore(expected);
    const PointMatrix found = sampler.Integrate(noise, request).cast<double>();
    const double moved = (flown - expected).rowwise().norm().maxCoeff();
    EXPECT_GT(moved, 1e-4);
    EXPECT_LT((found - expected).rowwise().norm().maxCoeff(), 1e-2 * moved);
  }
}

TEST(CoupledFlow, OfAPartKeepsItsPlace)
{
  const TriangleMesh mesh = BodyWithEye();
  MeshNormalization whole = FlowNormalization(mesh);
  whole.Center[0] += 0.2 * whole.Scale;
  whole.Scale *= 1.3;
  const TriangleMesh source = Normalized(mesh, whole);
  const Eigen::VectorXd mass = LumpedMass(source, MeshTopology(source));
  const FlowMatchingSampler sampler(Model(FlowPrediction::Velocity), mesh, nullptr, {}, Coupled(), whole);
  const FeatureMatrix state = sampler.Integrate(sampler.InitialNoise(Request()), Request());
  const Eigen::RowVector3d expected = mass.transpose() * source.Points / mass.sum();
  const Eigen::RowVector3d found = mass.transpose() * state.cast<double>() / mass.sum();
  EXPECT_GT(expected.norm(), 0.1);
  EXPECT_LT((found - expected).norm(), 1e-4);
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

TEST(CoupledOffsets, TurnWithTheSurfaceAroundThem)
{
  const TriangleMesh mesh = BodyWithEye();
  const MeshTopology topology(mesh);
  const PoissonOperators operators = BuildPoissonOperators(mesh, topology, {}, PoissonShift::Mass, Coupled());
  const CoupledOffsets offsets(mesh, topology, Coupled(), operators.Solver);
  const Index body = Body().NumberOfPoints();
  const double size = std::sqrt(static_cast<double>(operators.VertexMass.sum()));
  PointMatrix same = mesh.Points;
  offsets.Restore(same);
  EXPECT_LT((same - mesh.Points).cwiseAbs().maxCoeff(), 1e-9);
  for (const double angle : { 0.5, 2.0, 3.1 })
  {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).matrix();
    const PointMatrix turned = mesh.Points * turn.transpose();
    PointMatrix positions = turned;
    positions.bottomRows(mesh.NumberOfPoints() - body).rowwise() += Eigen::RowVector3d(0.1, -0.2, 0.05);
    const Eigen::RowVector3d mean = operators.VertexMass.cast<double>().transpose() * positions;
    offsets.Restore(positions);
    const Eigen::RowVector3d other = operators.VertexMass.cast<double>().transpose() * positions;
    EXPECT_LT((other - mean).norm(), 1e-6) << "the mean stays";
    const Eigen::RowVector3d shift = turned.row(body / 2) - positions.row(body / 2);
    positions.rowwise() += shift;
    EXPECT_LT((positions - turned).rowwise().norm().maxCoeff(), 1e-3 * size) << "turned by " << angle;
  }
}

TEST(CoupledOffsets, TurnWithSurfacesOfFewTriangles)
{
  // The triangles are larger than the surroundings of a pair.
  const TriangleMesh body = test::PlanePatch(1, 1, 4.0, 4.0);
  const TriangleMesh mesh = test::Join(body, test::Translated(test::PlanePatch(4, 4, 0.4, 0.4), { 2.2, 1.0, 0.08 }));
  ComponentCoupling coupling = Coupled();
  coupling.Distance = 0.1;
  const MeshTopology topology(mesh);
  const PoissonOperators operators = BuildPoissonOperators(mesh, topology, {}, PoissonShift::Mass, coupling);
  const CoupledOffsets offsets(mesh, topology, coupling, operators.Solver);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, -1.0, 0.5).normalized()).matrix();
  const PointMatrix turned = mesh.Points * turn.transpose();
  PointMatrix positions = turned;
  positions.bottomRows(25).rowwise() += Eigen::RowVector3d(0.2, 0.1, -0.3);
  offsets.Restore(positions);
  const Eigen::RowVector3d shift = turned.row(0) - positions.row(0);
  positions.rowwise() += shift;
  EXPECT_LT((positions - turned).rowwise().norm().maxCoeff(), 2e-3);
}

TEST(CoupledOffsets, OfASymmetricBodyDoNotDependOnTheOrderOfComponents)
{
  // Places of pairs lie on planes of symmetry, and nearest places are corners of several triangles.
  const TriangleMesh body = test::UvSphere(12, 16), eye = test::UvSphere(6, 8, 0.9);
  const TriangleMesh meshes[] = { test::Join(body, eye), test::Join(eye, body) };
  const Index split[] = { body.NumberOfPoints(), eye.NumberOfPoints() };
  PointMatrix found[2];
  for (int k = 0; k < 2; ++k)
  {
    const MeshTopology topology(meshes[k]);
    const PoissonOperators operators = BuildPoissonOperators(meshes[k], topology, {}, PoissonShift::Mass, Coupled());
    const CoupledOffsets offsets(meshes[k], topology, Coupled(), operators.Solver);
    PointMatrix positions = meshes[k].Points;
    positions.col(0) += 0.3 * meshes[k].Points.col(1).array().square().matrix();
    positions.col(2) += 0.4 * meshes[k].Points.col(0).array().sin().matrix();
    offsets.Restore(positions);
    found[k].resize(positions.rows(), 3);
    found[k] << positions.topRows(split[k]), positions.bottomRows(split[1 - k]);
  }
  EXPECT_LT((found[0].topRows(split[0]) - found[1].bottomRows(split[0])).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((found[0].bottomRows(split[1]) - found[1].topRows(split[1])).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(CoupledOffsets, CanBeCancelledAndTakeAnyDistance)
{
  const TriangleMesh mesh = BodyWithEye();
  const MeshTopology topology(mesh);
  const PoissonOperators operators = BuildPoissonOperators(mesh, topology, {}, PoissonShift::Mass, Coupled());
  for (const double stop : { 0.1, 0.9 })
  {
    const auto isBefore = [stop](double fraction) { return fraction < stop; };
    EXPECT_THROW(CoupledOffsets(mesh, topology, Coupled(), operators.Solver, isBefore), Cancelled);
  }
  // Components that touch are coupled at any distance.
  const TriangleMesh touching = test::Join(
    test::PlanePatch(3, 3), test::Translated(test::PlanePatch(3, 3), { 1, 0, 0 }));
  ComponentCoupling near = Coupled();
  near.Distance = 1e-20;
  const MeshTopology tables(touching);
  const PoissonOperators stiff = BuildPoissonOperators(touching, tables, {}, PoissonShift::Mass, near);
  PointMatrix positions = touching.Points;
  positions.bottomRows(16).array() += 0.1;
  CoupledOffsets(touching, tables, near, stiff.Solver).Restore(positions);
  EXPECT_TRUE(positions.allFinite());
  EXPECT_LT((positions.row(3) - positions.row(16)).norm(), 1e-3) << "where they touch";
}

TEST(CoupledOffsets, OfPartsOfABentBodyTurnEachWithItsPlace)
{
  // A sheet that is rolled up, with a tile under each end.
  const TriangleMesh sheet = test::PlanePatch(40, 8, 4.0, 0.8);
  const auto tile = [](double x) { return test::Translated(test::PlanePatch(4, 4, 0.4, 0.4), { x, 0.2, -0.05 }); };
  const TriangleMesh mesh = test::Join(test::Join(sheet, tile(0.1)), tile(3.4));
  ComponentCoupling coupling = Coupled();
  coupling.Distance = 0.1;
  const MeshTopology topology(mesh);
  const PoissonOperators operators = BuildPoissonOperators(mesh, topology, {}, PoissonShift::Mass, coupling);
  const CoupledOffsets offsets(mesh, topology, coupling, operators.Solver);
  const double radius = 1.2;
  PointMatrix rolled = mesh.Points;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double angle = mesh.Points(v, 0) / radius;
    const double r = radius - mesh.Points(v, 2);
    rolled.row(v) << r * std::sin(angle), mesh.Points(v, 1), radius - r * std::cos(angle);
  }
  PointMatrix positions = rolled;
  const Index first = sheet.NumberOfPoints();
  positions.bottomRows(mesh.NumberOfPoints() - first).array() += 0.04;
  offsets.Restore(positions);
  EXPECT_LT((positions - rolled).rowwise().norm().maxCoeff(), 0.012);
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
