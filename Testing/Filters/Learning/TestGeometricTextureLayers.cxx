// SPDX-License-Identifier: BSD-3-Clause
// Layers and losses of geometric textures: values against the core's, gradients against finite differences, in float64.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshTopology.h"
#include "Learning/Layers/FaceConvolution.h"
#include "Learning/Layers/RingFeatureTensors.h"
#include "Learning/Losses/GeometricTextureLosses.h"
#include "Learning/Losses/MeshFitLosses.h"
#include "Learning/Networks/InitialWeights.h"

#include <gtest/gtest.h>

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

using namespace surfsynth;

namespace
{

/// A sphere without symmetries, so that no two edges or neighbours tie for a maximum.
TriangleMesh TextureSurface() { return test::IrregularSphere(1); }

torch::Tensor PointsOf(const TriangleMesh& mesh)
{
  return torch::from_blob(const_cast<double*>(mesh.Points.data()), { mesh.Points.rows(), 3 }, torch::kFloat64).clone();
}

/// Numbers in [-1, 1) that depend on @p seed only.
torch::Tensor Numbers(std::vector<std::int64_t> shape, std::uint64_t seed)
{
  const torch::Tensor numbers = torch::empty(shape, torch::kFloat64);
  for (std::int64_t k = 0; k < numbers.numel(); ++k)
  {
    numbers.data_ptr<double>()[k] = test::Uniform(seed, static_cast<std::uint64_t>(k));
  }
  return numbers;
}

GeometricTextureOptions SmallTextureOptions()
{
  GeometricTextureOptions options;
  options.Levels = 2;
  options.Layers = 4;
  options.StartChannels = 6;
  options.MinimumChannels = 4;
  options.MaximumChannels = 8;
  return options;
}

GeometricTextureNetwork SmallNetwork(bool discriminator)
{
  GeometricTextureNetwork network = MakeGeometricTextureNetwork(
    SmallTextureOptions(), discriminator, InitialGeometricTextureTensors(SmallTextureOptions(), discriminator, 5));
  network->to(torch::kFloat64);
  return network;
}

/// The derivative of @p loss along a direction at @p x, by autograd and by central differences.
void ExpectGradient(const std::function<torch::Tensor(const torch::Tensor&)>& loss, const torch::Tensor& x)
{
  constexpr double step = 1e-6;
  const torch::Tensor direction = Numbers(x.sizes().vec(), 77);
  const torch::Tensor variable = x.detach().clone().requires_grad_();
  const torch::Tensor gradient = torch::autograd::grad({ loss(variable) }, { variable })[0];
  const double found = (gradient * direction).sum().item<double>();
  const double above = loss(x.detach() + step * direction).item<double>();
  const double below = loss(x.detach() - step * direction).item<double>();
  const double expected = (above - below) / (2.0 * step);
  EXPECT_NEAR(found, expected, 1e-6 * std::max(1e-3, std::abs(expected)));
}

/// The same for a loss of a network's parameters, one after the other.
void ExpectParameterGradients(torch::nn::Module& network, const std::function<torch::Tensor()>& loss)
{
  constexpr double step = 1e-6;
  for (auto& parameter : network.named_parameters())
  {
    torch::Tensor value = parameter.value();
    const torch::Tensor gradient = torch::autograd::grad({ loss() }, { value }, {}, c10::nullopt, false, true)[0];
    const torch::Tensor direction = Numbers(value.sizes().vec(), 77);
    const auto moved = [&](double distance) {
      const torch::Tensor before = value.detach().clone();
      value.data().add_(direction, distance);
      const double result = loss().item<double>();
      value.data().copy_(before);
      return result;
    };
    const double expected = (moved(step) - moved(-step)) / (2.0 * step);
    const double found = gradient.defined() ? (gradient * direction).sum().item<double>() : 0.0;
    EXPECT_NEAR(found, expected, 1e-6 * std::max(1e-3, std::abs(expected))) << parameter.key();
  }
}

/// Value and derivatives of a critic on a surface, in one type: by the features and by each parameter of its mean value and
/// of the gradient penalty.
std::vector<torch::Tensor> CriticDerivatives(const TriangleMesh& mesh, torch::Dtype type, bool fused)
{
  FaceTables tables(mesh, type);
  if (!fused)
  {
    tables.OfNeighbors.reset();
  }
  GeometricTextureOptions options = SmallTextureOptions();
  options.StartChannels = 37; // whole vectors and a rest
  options.MinimumChannels = 20;
  options.MaximumChannels = 37;
  GeometricTextureNetwork network = MakeGeometricTextureNetwork(
    options, true, InitialGeometricTextureTensors(options, true, 5));
  network->to(type);
  GeometricTextureLevelNetworkImpl& critic = network->Level(0);
  const torch::Tensor real = EdgeFeatureTensor(FaceTables(mesh, torch::kFloat64), PointsOf(mesh));
  const torch::Tensor fake = (real + 0.3 * Numbers({ mesh.Triangles.rows(), 12 }, 9)).to(type).requires_grad_();
  const torch::Tensor value = CriticValue(critic, tables, fake);
  const torch::Tensor penalty = GradientPenalty(critic, tables, real.to(type), fake, 0.3);
  std::vector<torch::Tensor> found = { value.detach(), penalty.detach() };
  std::vector<torch::Tensor> inputs = critic.parameters();
  for (const torch::Tensor& gradient : torch::autograd::grad({ penalty }, inputs, {}, c10::nullopt, false, true))
  {
    found.push_back(gradient.defined() ? gradient : torch::zeros({ 1 }));
  }
  inputs.push_back(fake);
  for (const torch::Tensor& gradient : torch::autograd::grad({ value }, inputs))
  {
    found.push_back(gradient);
  }
  return found;
}

/// Largest difference over the largest entry; the biases before a norm have derivatives of 0 and what rounding left of it.
double RelativeDifference(const torch::Tensor& a, const torch::Tensor& b, double smallest)
{
  const double scale = std::max(smallest, b.abs().max().item<double>());
  return (a.to(torch::kFloat64) - b.to(torch::kFloat64)).abs().max().item<double>() / scale;
}

} // namespace

TEST(FusedFaceConvolutions, FirstAndSecondDerivativesAreThoseOfThePlainExpressions)
{
  for (const TriangleMesh& mesh : { test::IrregularSphere(2), test::PlanePatch(9, 8, 1.0, 1.0, 0.2) })
  {
    const std::vector<torch::Tensor> fused = CriticDerivatives(mesh, torch::kFloat32, true);
    const std::vector<torch::Tensor> plain = CriticDerivatives(mesh, torch::kFloat32, false);
    const std::vector<torch::Tensor> exact = CriticDerivatives(mesh, torch::kFloat64, false);
    ASSERT_EQ(fused.size(), exact.size());
    for (std::size_t k = 0; k < exact.size(); ++k)
    {
      EXPECT_LT(RelativeDifference(fused[k], exact[k], 1e-3), 1e-4) << k;
      // As near to the numbers in double precision as the plain expressions in single precision. A single number, value or
      // penalty, may be near by chance: its last bits depend on the order of sums in matrix products, another one on each
      // processor.
      const double near = 2.0 * RelativeDifference(plain[k], exact[k], 1e-3) + 1e-6;
      EXPECT_LT(RelativeDifference(fused[k], exact[k], 1e-3), exact[k].numel() > 1 ? near : 2e-5) << k;
    }
  }
}

TEST(FusedFrames, FeaturesAndDisplacementsHaveTheDerivativesOfThePlainExpressions)
{
  for (const TriangleMesh& mesh : { test::IrregularSphere(2), test::PlanePatch(9, 8, 1.0, 1.0, 0.2) })
  {
    const FaceTables tables(mesh, torch::kFloat64);
    const FaceTables single(mesh, torch::kFloat32);
    const std::int64_t faces = mesh.Triangles.rows();
    const torch::Tensor ofFeatures = Numbers({ faces, 12 }, 1);
    const torch::Tensor ofPoints = Numbers({ mesh.Points.rows(), 3 }, 2);
    const torch::Tensor points = PointsOf(mesh) + 0.05 * Numbers({ mesh.Points.rows(), 3 }, 4);
    const auto evaluate = [&](const FaceTables& of, torch::Dtype type) {
      const torch::Tensor x = points.to(type).requires_grad_();
      const torch::Tensor local = Numbers({ faces, 3 }, 3).to(type).requires_grad_();
      const torch::Tensor features = EdgeFeatureTensor(of, x);
      const torch::Tensor moved = CornerDisplacement(of, x, local);
      const auto sum = [&type](const torch::Tensor& values, const torch::Tensor& weights) {
        return (values * weights.to(type)).sum();
      };
      const auto first = torch::autograd::grad({ sum(features, ofFeatures) }, { x });
      const auto second = torch::autograd::grad({ sum(moved, ofPoints) }, { x, local });
      return std::vector<torch::Tensor>{ features, moved, first[0], second[0], second[1] };
    };
    const std::vector<torch::Tensor> exact = evaluate(tables, torch::kFloat64);
    const std::vector<torch::Tensor> fused = evaluate(single, torch::kFloat32);
    for (std::size_t k = 0; k < exact.size(); ++k)
    {
      EXPECT_LT(RelativeDifference(fused[k], exact[k], 1e-3), 1e-5) << k;
    }
  }
}

TEST(FusedFaceConvolutions, HaveTheSameBitsForEachNumberOfThreads)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  const std::vector<torch::Tensor> one = CriticDerivatives(mesh, torch::kFloat32, true);
  const int before = at::get_num_threads();
  at::set_num_threads(3);
  const std::vector<torch::Tensor> three = CriticDerivatives(mesh, torch::kFloat32, true);
  at::set_num_threads(before);
  for (std::size_t k = 0; k < one.size(); ++k)
  {
    EXPECT_TRUE(one[k].equal(three[k])) << k;
  }
}

TEST(FusedFaceConvolutions, RefuseThirdDerivatives)
{
  const TriangleMesh mesh = TextureSurface();
  const FaceTables tables(mesh, torch::kFloat32);
  GeometricTextureNetwork network = SmallNetwork(true);
  network->to(torch::kFloat32);
  GeometricTextureLevelNetworkImpl& critic = network->Level(0);
  const torch::Tensor real = EdgeFeatureTensor(tables, PointsOf(mesh).to(torch::kFloat32));
  const torch::Tensor penalty = GradientPenalty(critic, tables, real, 1.1 * real, 0.3);
  const std::vector<torch::Tensor> parameters = critic.parameters();
  EXPECT_THROW(torch::autograd::grad({ penalty }, { parameters[0] }, {}, true, true), InvalidInput);
}

TEST(GeometricTextureLayers, FeaturesAndDisplacementsAreTheCores)
{
  const TriangleMesh mesh = TextureSurface();
  const FaceTables tables(mesh, torch::kFloat64);
  const SinglePoints points = mesh.Points.cast<float>();
  const EdgeFeatureMatrix expected = ComputeEdgeFeatures(points, mesh.Triangles, ComputeFaceNeighbors(mesh));
  const torch::Tensor features = EdgeFeatureTensor(tables, PointsOf(mesh));
  ASSERT_EQ(features.numel(), expected.size());
  for (std::int64_t k = 0; k < features.numel(); ++k)
  {
    EXPECT_NEAR(features.data_ptr<double>()[k], expected.data()[k], 1e-5);
  }
  const torch::Tensor local = Numbers({ mesh.Triangles.rows(), 3 }, 3);
  const SinglePoints single = Eigen::Map<const PointMatrix>(local.data_ptr<double>(), local.size(0), 3).cast<float>();
  const SinglePoints moved = MeanCornerDisplacement(points, mesh.Triangles, single);
  const torch::Tensor found = CornerDisplacement(tables, PointsOf(mesh), local).contiguous();
  for (std::int64_t k = 0; k < found.numel(); ++k)
  {
    EXPECT_NEAR(found.data_ptr<double>()[k], moved.data()[k], 1e-5);
  }
}

TEST(GeometricTextureLayers, FeaturesOfOpenSurfacesAreTheCoresAndSoAreTheirFusedDerivatives)
{
  const TriangleMesh mesh = test::PlanePatch(5, 4, 5.0, 4.0, 0.3);
  const EdgeFeatureMatrix expected = ComputeEdgeFeatures(
    mesh.Points.cast<float>(), mesh.Triangles, ComputeFaceNeighbors(mesh));
  const torch::Tensor weights = Numbers({ mesh.Triangles.rows(), 12 }, 1);
  std::vector<torch::Tensor> gradients;
  for (const auto type : { torch::kFloat64, torch::kFloat32 }) // the second is fused
  {
    const torch::Tensor points = PointsOf(mesh).to(type).requires_grad_();
    const torch::Tensor features = EdgeFeatureTensor(FaceTables(mesh, type), points);
    const torch::Tensor found = features.detach().to(torch::kFloat32).contiguous();
    for (std::int64_t k = 0; k < found.numel(); ++k)
    {
      EXPECT_NEAR(found.data_ptr<float>()[k], expected.data()[k], 1e-5);
    }
    gradients.push_back(
      torch::autograd::grad({ (features * weights.to(type)).sum() }, { points })[0].to(torch::kFloat64));
  }
  EXPECT_TRUE(torch::allclose(gradients[0], gradients[1], 1e-4, 1e-4));
  const FaceTables tables(mesh, torch::kFloat64);
  ExpectGradient(
    [&](const torch::Tensor& x) { return (EdgeFeatureTensor(tables, x) * weights).sum(); }, PointsOf(mesh));
}

TEST(GeometricTextureLayers, SubdivisionDoublesTheCoresPoints)
{
  const TriangleMesh mesh = TextureSurface();
  const SubdividedMesh expected = SubdivideAtMidpoints(mesh);
  const torch::Tensor found = DoubledSubdivision(PointsOf(mesh), ParentTensor(expected, torch::kCPU));
  EXPECT_TRUE(torch::allclose(found, 2.0 * PointsOf(expected.Mesh), 1e-14, 1e-14));
}

TEST(GeometricTextureLayers, AFaceConvolutionIsTheLargestOfItsNeighbors)
{
  const TriangleMesh mesh = TextureSurface();
  const FaceTables tables(mesh, torch::kFloat64);
  FaceConvolution convolution(FaceConvolutionOptions(5, 4));
  convolution->to(torch::kFloat64);
  const auto parameters = convolution->named_parameters();
  const torch::Tensor weight = parameters["conv.weight"];
  EXPECT_EQ(weight.sizes().vec(), (std::vector<std::int64_t>{ 4, 10, 1 }));
  const torch::Tensor x = Numbers({ mesh.Triangles.rows(), 5 }, 4);
  const torch::Tensor pairs = torch::cat({ x.index({ tables.Neighbors }), x.unsqueeze(1).expand({ -1, 3, -1 }) }, -1);
  const torch::Tensor expected = std::get<0>((pairs.matmul(weight.squeeze(-1).t()) + parameters["conv.bias"]).max(1));
  EXPECT_TRUE(torch::allclose(convolution->forward(tables, x), expected, 1e-12, 1e-12));
}

TEST(GeometricTextureLayers, ResultsDoNotDependOnWhichCornerComesFirst)
{
  const TriangleMesh mesh = TextureSurface();
  TriangleMesh turned = mesh;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    turned.Triangles.row(f) << mesh.Triangles(f, 1), mesh.Triangles(f, 2), mesh.Triangles(f, 0);
  }
  GeometricTextureNetwork critic = SmallNetwork(true);
  const auto scores = [&](const TriangleMesh& surface) {
    const FaceTables tables(surface, torch::kFloat64);
    return critic->Level(0).forward(tables, EdgeFeatureTensor(tables, PointsOf(surface)));
  };
  EXPECT_TRUE(torch::allclose(scores(mesh), scores(turned), 1e-10, 1e-10));
}

TEST(GeometricTextureLayers, GradientsAreThoseOfFiniteDifferences)
{
  const TriangleMesh mesh = TextureSurface();
  const FaceTables tables(mesh, torch::kFloat64);
  const std::int64_t faces = mesh.Triangles.rows();
  const torch::Tensor ofFeatures = Numbers({ faces, 12 }, 1);
  const torch::Tensor ofPoints = Numbers({ mesh.Points.rows(), 3 }, 2);
  const torch::Tensor local = Numbers({ faces, 3 }, 3);
  ExpectGradient(
    [&](const torch::Tensor& x) { return (EdgeFeatureTensor(tables, x) * ofFeatures).sum(); }, PointsOf(mesh));
  ExpectGradient(
    [&](const torch::Tensor& x) { return (CornerDisplacement(tables, x, local) * ofPoints).sum(); }, PointsOf(mesh));
  ExpectGradient(
    [&](const torch::Tensor& x) { return (CornerDisplacement(tables, PointsOf(mesh), x) * ofPoints).sum(); }, local);
  const SubdividedMesh finer = SubdivideAtMidpoints(mesh);
  const torch::Tensor ofFiner = Numbers({ finer.Mesh.Points.rows(), 3 }, 6);
  const torch::Tensor parents = ParentTensor(finer, torch::kCPU);
  ExpectGradient(
    [&](const torch::Tensor& x) { return (DoubledSubdivision(x, parents) * ofFiner).sum(); }, PointsOf(mesh));
  GeometricTextureNetwork generator = SmallNetwork(false);
  ExpectGradient(
    [&](
      const torch::Tensor& x) { return (Displaced(generator->Level(0), tables, x, 0.1 * ofPoints) * ofPoints).sum(); },
    PointsOf(mesh));
}

TEST(RingFeatureTensors, AreTheCores)
{
  TriangleMesh open = test::IrregularSphere(2);
  open.Triangles.conservativeResize(open.Triangles.rows() - 40, 3);
  for (const TriangleMesh& mesh : { test::IrregularSphere(2), open, TextureSurface() })
  {
    for (const int rings : { 1, 3, 6 })
    {
      const FaceTables faces(mesh, torch::kFloat64);
      const RingTables tables(mesh, rings, torch::kFloat64);
      const torch::Tensor found = RingFeatureTensor(faces, tables, PointsOf(mesh));
      const RingFeatureMatrix expected = ComputeRingFeatures(mesh, MeshTopology(mesh), rings);
      ASSERT_EQ(found.size(0), expected.rows()) << rings;
      ASSERT_EQ(found.size(1), expected.cols()) << rings;
      const torch::Tensor core = torch::from_blob(
        const_cast<float*>(expected.data()), { expected.rows(), expected.cols() }, torch::kFloat32);
      EXPECT_LT((found - core).abs().max().item<double>(), 1e-5) << rings;
      const torch::Tensor some = torch::arange(1, found.size(0), 7);
      const torch::Tensor ofSome = RingFeatureTensor(faces, tables.Take(some), PointsOf(mesh));
      EXPECT_LT((ofSome - found.index_select(0, some)).abs().max().item<double>(), 1e-12) << rings;
    }
  }
}

TEST(GeometricTextureLosses, SlicedDistancesAreThoseOfTheCore)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  const torch::Tensor features = EdgeFeatureTensor(FaceTables(mesh, torch::kFloat64), PointsOf(mesh));
  const torch::Tensor moved = features + 0.1 * Numbers({ features.size(0), features.size(1) }, 4);
  const torch::Tensor axis = torch::zeros({ 12, 1 }, torch::kFloat64);
  axis[2][0] = 1.0;
  // Along one axis: the mean distance of the values of three edges, in ascending order.
  const auto values = [](const torch::Tensor& of) {
    return std::get<0>(torch::cat({ of.select(1, 2), of.select(1, 6), of.select(1, 10) }).sort());
  };
  const double expected = (values(features) - values(moved)).abs().mean().item<double>();
  const double found = SlicedWassersteinLoss(AllEdgeOrders(moved), AllEdgeOrders(features), axis).item<double>();
  EXPECT_NEAR(found, expected, 1e-12);
  EXPECT_GT(found, 0.001);
  EXPECT_EQ(SlicedWassersteinLoss(features, features, Numbers({ 12, 5 }, 8)).item<double>(), 0.0);
}

TEST(GeometricTextureLosses, GradientsOfThePenaltyAreThoseOfFiniteDifferences)
{
  const TriangleMesh mesh = TextureSurface();
  const FaceTables tables(mesh, torch::kFloat64);
  GeometricTextureNetwork network = SmallNetwork(true);
  GeometricTextureLevelNetworkImpl& critic = network->Level(0);
  const torch::Tensor real = EdgeFeatureTensor(tables, PointsOf(mesh));
  const torch::Tensor fake = real + 0.3 * Numbers({ mesh.Triangles.rows(), 12 }, 9);
  ExpectParameterGradients(critic, [&] { return GradientPenalty(critic, tables, real, fake, 0.3); });
  ExpectParameterGradients(critic, [&] { return CriticValue(critic, tables, fake); });
  ExpectGradient([&](const torch::Tensor& x) { return CriticValue(critic, tables, x); }, fake);
}

TEST(GeometricTextureLosses, GradientsOfTheFitAreThoseOfFiniteDifferences)
{
  const TriangleMesh mesh = TextureSurface();
  const FitTables tables(mesh, torch::kFloat64);
  ExpectGradient([&](const torch::Tensor& x) { return ComputeTriangulationLoss(tables, x).Total; }, PointsOf(mesh));
  constexpr std::int64_t count = 40;
  SurfaceSamples samples;
  samples.Faces = torch::arange(count) % mesh.Triangles.rows();
  samples.Weights = torch::softmax(Numbers({ count, 3 }, 8), -1);
  const SampledSurface target = EvaluateSamples(tables, 1.2 * PointsOf(mesh).flip(1), samples);
  const torch::Tensor distances = torch::cdist(EvaluateSamples(tables, PointsOf(mesh), samples).Points, target.Points);
  const NearestSampleIds nearest{ distances.argmin(1), distances.argmin(0) };
  for (const bool published : { false, true })
  {
    ExpectGradient(
      [&](const torch::Tensor& x) {
        return ComputeChamferLoss(EvaluateSamples(tables, x, samples), target, nearest, published).Total;
      },
      PointsOf(mesh));
  }
}

TEST(GeometricTextureLosses, AnEvenTriangulationOfOneTriangleIsKnown)
{
  TriangleMesh mesh;
  mesh.Points.resize(3, 3);
  mesh.Points << 0, 0, 0, 3, 0, 0, 0, 4, 0; // sides 3, 5, 4
  mesh.Triangles.resize(1, 3);
  mesh.Triangles << 0, 1, 2;
  const TriangulationLoss loss = ComputeTriangulationLoss(FitTables(mesh, torch::kFloat64), PointsOf(mesh));
  EXPECT_NEAR(loss.EdgeDeviation.item<double>(), 1.0, 1e-12);
  const double entropy = 0.25 * std::log(0.25) + 5.0 / 12.0 * std::log(5.0 / 12.0) + std::log(1.0 / 3.0) / 3.0;
  EXPECT_NEAR(loss.EdgeEntropy.item<double>(), entropy, 1e-12);
  // From the mean of the two others: (1.5, 2), (3, 2), (1.5, 4).
  EXPECT_NEAR(loss.Roughness.item<double>(), (3.5 + 5.0 + 5.5) / 3.0, 1e-12);
}

TEST(GeometricTextureLosses, TablesRefuseIdsThatDoNotExist)
{
  TriangleMesh mesh = test::SingleTriangle();
  mesh.Triangles(0, 1) = 3;
  EXPECT_THROW(FitTables(mesh, torch::kFloat64), InvalidInput);
}
