// SPDX-License-Identifier: BSD-3-Clause
// Field latents with LibTorch: the evaluators without it, the steps with derivatives of their own, the losses.
#include "RandomFieldLatents.h"

#include "Core/Common/Errors.h"
#include "Learning/Losses/FieldLatentLosses.h"
#include "Learning/Networks/FieldLatentNetworks.h"
#include "Learning/Networks/InitialWeights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace surfsynth;

namespace
{
torch::Tensor TensorOf(const FieldLatentMatrix& matrix, std::vector<std::int64_t> shape)
{
  return torch::from_blob(const_cast<float*>(matrix.data()), shape, torch::kFloat32).to(torch::kFloat64);
}

/// Largest difference, relative to the largest number where that is above 1.
double FarthestApart(const torch::Tensor& a, const torch::Tensor& b)
{
  const torch::Tensor x = a.to(torch::kFloat64);
  const torch::Tensor y = b.to(torch::kFloat64);
  return (x - y).abs().max().item<double>() / std::max(1.0, y.abs().max().item<double>());
}

/// Encodes and decodes with LibTorch in float64, which has the plain expressions, and without LibTorch.
void ExpectSameResults(const FieldLatentModel& model, std::int64_t vertices)
{
  const torch::NoGradGuard noGradients;
  const FieldLatentOptions& options = model.Options;
  FieldLatentNetwork network = MakeFieldLatentNetwork(model);
  network->to(torch::kFloat64);
  const std::int64_t samples = options.SamplesPerRing;
  const std::int64_t dimension = options.LatentDimension;
  const FieldLatentRings rings = test::RandomRings(vertices, samples);
  const FieldLatentGaussians gaussians = network->Encoder(
    TensorOf(rings.Logarithms, { vertices, samples, 2 }), TensorOf(rings.Colors, { vertices, samples, 3 }));
  const FieldLatentCodes codes = FieldLatentEncoder(model).Encode(rings);
  EXPECT_LT(FarthestApart(TensorOf(codes.Mean, { vertices, dimension, 2 }), gaussians.Mean), 1e-5);
  EXPECT_LT(FarthestApart(TensorOf(codes.LogDeviation, { vertices, dimension }), gaussians.LogDeviation), 1e-5);
  EXPECT_GT(gaussians.Mean.abs().max().item<double>(), 0.01);

  const std::int64_t count = 40;
  const FieldLatentMatrix latents = test::RandomLatents(vertices, dimension);
  const FieldLatentTexels texels = test::RandomTexels(count, vertices);
  const FieldLatentMatrix colors = FieldLatentDecoder(model).Decode(latents, texels);
  const torch::Tensor corners =
    torch::from_blob(const_cast<Index*>(texels.Corners.data()), { count * 3 }, torch::kInt32).to(torch::kInt64);
  const torch::Tensor atCorners = TensorOf(latents, { vertices, dimension, 2 }).index_select(0, corners);
  const torch::Tensor barycentric = TensorOf(texels.Barycentric, { count, 1, 3 });
  torch::Tensor expected;
  if (options.Coordinates == FieldLatentCoordinates::Logarithmic)
  {
    const torch::Tensor each = network->Decoder(atCorners, TensorOf(texels.Logarithms, { 3 * count, 1, 2 }));
    expected = torch::matmul(barycentric, each.view({ count, 3, 3 }));
  }
  else
  {
    expected = network->Decoder->Blended(atCorners.view({ count, 3, dimension, 2 }), barycentric);
  }
  EXPECT_LT(FarthestApart(TensorOf(colors, { count, 3 }), expected.view({ count, 3 })), 1e-5);
}

/// Values and derivatives of a layer on [3, 7, 2 C] in float32 and in float64, where there are no fused steps.
template <typename Layer>
void ExpectFusedStepsAreExact(Layer layer)
{
  const FieldLatentMatrix numbers = test::RandomLatents(21, 12);
  const FieldLatentMatrix weights = test::RandomLatents(42, 6);
  std::vector<std::vector<torch::Tensor>> results;
  for (const torch::ScalarType type : { torch::kFloat64, torch::kFloat32 })
  {
    layer->to(type);
    layer->zero_grad();
    torch::Tensor x = TensorOf(numbers, { 3, 7, 24 }).to(type).requires_grad_(true);
    const torch::Tensor y = layer->forward(x);
    (y * TensorOf(weights, { 3, 7, 24 }).to(type)).sum().backward();
    results.push_back({ y.detach(), x.grad() });
    for (const torch::Tensor& parameter : layer->parameters())
    {
      results.back().push_back(parameter.grad().clone());
    }
  }
  for (std::size_t k = 0; k < results[0].size(); ++k)
  {
    EXPECT_GT(results[0][k].abs().max().template item<double>(), 1e-3) << k;
    EXPECT_LT(FarthestApart(results[1][k], results[0][k]), 1e-5) << k;
  }
}
} // namespace

TEST(FieldLatentNetworks, EvaluatorsGiveTheResultsOfLibTorch)
{
  ExpectSameResults(test::RandomFieldLatents(), 9);
  ExpectSameResults(test::RandomFieldLatents(FieldLatentOptions::Small()), 20);
  FieldLatentOptions barycentric = test::TinyFieldLatents();
  barycentric.Coordinates = FieldLatentCoordinates::Barycentric;
  ExpectSameResults(test::RandomFieldLatents(barycentric), 9);
}

TEST(FieldLatentNetworks, EvaluatorsGiveTheResultsOfLibTorchAtThePapersSizes)
{
  ExpectSameResults(InitialFieldLatents(FieldLatentOptions::Paper(), 1), 8);
}

TEST(FieldLatentNetworks, ParametersAreThoseOfTheModelFile)
{
  for (const FieldLatentCoordinates coordinates :
    { FieldLatentCoordinates::Logarithmic, FieldLatentCoordinates::Barycentric })
  {
    FieldLatentOptions options = test::TinyFieldLatents();
    options.Coordinates = coordinates;
    std::map<std::string, std::vector<std::int64_t>> found;
    for (const auto& parameter : FieldLatentNetwork(options)->named_parameters())
    {
      found[parameter.key()] = parameter.value().sizes().vec();
    }
    EXPECT_EQ(found, ExpectedFieldLatentTensors(options));
  }
}

TEST(FieldLatentLayers, FusedStepsHaveTheValuesAndDerivativesOfTheExpressions)
{
  torch::manual_seed(3);
  RingNorm norm(12);
  {
    const torch::NoGradGuard noGradients;
    for (torch::Tensor& parameter : norm->parameters())
    {
      parameter.uniform_(-1.0, 1.0);
    }
  }
  ExpectFusedStepsAreExact(norm);
  ExpectFusedStepsAreExact(VectorNeuron(12));
  ExpectFusedStepsAreExact(RingAttention(12, 3));
}

TEST(FieldLatentLayers, SecondDerivativesOfFusedStepsAreRefused)
{
  VectorNeuron layer(4);
  const torch::Tensor x = torch::ones({ 1, 2, 8 }).requires_grad_(true);
  EXPECT_THROW(torch::autograd::grad({ layer->forward(x).square().sum() }, { x }, {}, true, true), InvalidInput);
}

TEST(FieldLatentLosses, AreThoseOfTheEquations)
{
  const torch::Tensor predicted = torch::tensor({ 0.5F, -0.5F, 1.0F, 0.0F, 0.0F, 0.0F }).view({ 1, 2, 3 });
  EXPECT_NEAR(ColorLoss(predicted, torch::zeros({ 1, 2, 3 })).item<double>(), 1.0, 1e-6);
  // Two rings, one tangent vector each: (|m|^2 + s^2 - 1 - ln s^2) / 2 is 0 for the first.
  FieldLatentGaussians gaussians;
  gaussians.Mean = torch::tensor({ 0.0F, 0.0F, 3.0F, 4.0F }).view({ 2, 1, 2 });
  gaussians.LogDeviation = torch::tensor({ 0.0F, 0.5F }).view({ 2, 1 });
  EXPECT_NEAR(KullbackLeiblerLoss(gaussians).item<double>(), 0.5 * 0.5 * (25.0 + std::exp(1.0) - 1.0 - 1.0), 1e-5);
  const torch::Tensor latents = SampleLatents(gaussians, torch::ones({ 2, 1, 2 }));
  EXPECT_NEAR(latents[1][0][1].item<double>(), 4.0 + std::exp(0.5), 1e-5);
}
