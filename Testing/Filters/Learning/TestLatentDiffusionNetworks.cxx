// SPDX-License-Identifier: BSD-3-Clause
// The denoising network of field latents with LibTorch: the evaluator without it, derivatives, threads.
#include "ExampleMeshes.h"
#include "RandomFieldLatents.h"
#include "RandomLatentDiffusion.h"

#include "Core/Common/Errors.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"
#include "Learning/Layers/FusedFields.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Networks/LatentDiffusionNetworks.h"

#include <ATen/Parallel.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{
/// A surface on two levels, with labels from -1 on and directions, and a state on it.
struct DiffusionCase
{
  DiffusionCase(const LatentDiffusionOptions& options, int level)
    : Levels(std::make_shared<TangentHierarchy>(OneRings(test::IrregularSphere(level))))
  {
    const Index vertices = this->Levels->Fine.NumberOfVertices();
    this->State = test::RandomLatents(vertices, options.LatentDimension);
    for (Index v = 0; options.NumberOfLabels > 0 && v < vertices; ++v)
    {
      this->Conditions.Labels.push_back(v % 4 - 1);
    }
    if (options.Directed)
    {
      this->Conditions.Directions = 2.0F * test::RandomLatents(vertices, 1);
    }
    this->Surface = std::make_shared<const DiffusionSurface>(*this->Levels, this->Conditions);
  }

  torch::Tensor StateTensor(torch::ScalarType type) const
  {
    return torch::from_blob(
      const_cast<float*>(this->State.data()), { this->State.rows(), this->State.cols() }, torch::kFloat32)
      .to(type, false, true);
  }

  std::shared_ptr<const TangentHierarchy> Levels;
  std::shared_ptr<const DiffusionSurface> Surface;
  LatentDiffusionConditions Conditions;
  FieldLatentMatrix State;
};

/// Norm of the difference over that of @p b. Single numbers differ by more: directions of the shortest vectors are those
/// that rounding turns most.
double RelativeDifference(const torch::Tensor& a, const torch::Tensor& b)
{
  const torch::Tensor x = a.detach().to(torch::kFloat64);
  const torch::Tensor y = b.detach().to(torch::kFloat64);
  return (x - y).norm().item<double>() / y.norm().item<double>();
}

torch::Tensor AsTensor(const FieldLatentMatrix& matrix)
{
  return torch::from_blob(const_cast<float*>(matrix.data()), { matrix.rows(), matrix.cols() }, torch::kFloat32).clone();
}

void ExpectResultsOfTheEvaluator(const LatentDiffusionModel& model, int level)
{
  const torch::NoGradGuard noGradients;
  const DiffusionCase at(model.Options, level);
  const LatentDiffusionNetwork evaluator(model, at.Levels);
  LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  for (const torch::ScalarType type : { torch::kFloat32, torch::kFloat64 })
  {
    network->to(type);
    for (const bool guided : { true, false })
    {
      const torch::Tensor expected = AsTensor(
        evaluator.Evaluate(at.State, 37.0, guided ? at.Conditions : LatentDiffusionConditions()));
      const torch::Tensor found = network->forward(at.StateTensor(type), 37.0, at.Surface, guided);
      EXPECT_LT(RelativeDifference(found, expected), 1e-5) << type << guided;
      EXPECT_GT(expected.abs().max().item<double>(), 0.01);
    }
  }
}

/// Values and derivatives of a layer with random weights on five channels, in float32 and in float64, where there are no
/// steps.
void ExpectStepsAreExact(torch::nn::Module& layer, const DiffusionCase& at,
  const std::function<torch::Tensor(const torch::Tensor& x)>& forward)
{
  const std::int64_t vertices = at.Surface->Fine.NumberOfVertices();
  const torch::Tensor numbers = torch::randn({ vertices, 10 }, torch::kFloat32);
  {
    const torch::NoGradGuard noGradients;
    for (torch::Tensor& parameter : layer.parameters())
    {
      parameter.uniform_(-1.0, 1.0);
    }
  }
  std::map<torch::ScalarType, std::vector<torch::Tensor>> results;
  for (const torch::ScalarType type : { torch::kFloat32, torch::kFloat64 })
  {
    layer.to(type);
    layer.zero_grad();
    const torch::Tensor x = numbers.to(type, false, true).requires_grad_(true);
    const torch::Tensor y = forward(x);
    (y * torch::sin(torch::arange(y.numel(), torch::kFloat64)).view(y.sizes()).to(type)).sum().backward();
    results[type] = { y.detach(), x.grad() };
    for (const torch::Tensor& parameter : layer.parameters())
    {
      results[type].push_back(parameter.grad().clone());
    }
  }
  for (std::size_t k = 0; k < results[torch::kFloat64].size(); ++k)
  {
    const torch::Tensor& expected = results[torch::kFloat64][k];
    EXPECT_GT(expected.abs().max().item<double>(), 1e-3) << k;
    EXPECT_LT(RelativeDifference(results[torch::kFloat32][k], expected), 1e-5) << k;
  }
}

/// Derivatives of a weighted sum of the results by the state ("state") and all parameters.
std::map<std::string, torch::Tensor> Derivatives(
  LatentDenoisingNetwork network, const DiffusionCase& at, torch::ScalarType type)
{
  network->to(type);
  for (torch::Tensor& parameter : network->parameters())
  {
    parameter.mutable_grad() = torch::Tensor();
  }
  const torch::Tensor state = at.StateTensor(type).requires_grad_(true);
  const torch::Tensor weights = torch::sin(torch::arange(state.numel(), torch::kFloat64)).view(state.sizes()).to(type);
  (network->forward(state, 12.0, at.Surface) * weights).sum().backward();
  std::map<std::string, torch::Tensor> derivatives = { { "state", state.grad() } };
  for (const auto& parameter : network->named_parameters())
  {
    derivatives[parameter.key()] = parameter.value().grad().clone();
  }
  return derivatives;
}
} // namespace

TEST(LatentDenoisingNetwork, GivesTheResultsOfTheEvaluator)
{
  ExpectResultsOfTheEvaluator(test::RandomLatentDiffusion(), 1);
  ExpectResultsOfTheEvaluator(test::RandomLatentDiffusion(LatentDiffusionOptions::Small()), 2);
}

TEST(LatentDenoisingNetwork, ParametersAreThoseOfTheModelFile)
{
  LatentDiffusionOptions plain = test::TinyLatentDiffusion();
  plain.NumberOfLabels = 0;
  plain.Directed = false;
  plain.OutputBlocks = 2;
  for (const LatentDiffusionOptions& options : { test::TinyLatentDiffusion(), plain })
  {
    std::map<std::string, std::vector<std::int64_t>> found = { { "latent_scale", { options.LatentDimension } } };
    for (const auto& parameter : LatentDenoisingNetwork(options)->named_parameters())
    {
      found[parameter.key()] = parameter.value().sizes().vec();
    }
    EXPECT_EQ(found, ExpectedLatentDiffusionTensors(options));
  }
}

TEST(LatentDiffusionLayers, StepsHaveTheValuesAndDerivativesOfTheExpressions)
{
  torch::manual_seed(5);
  constexpr std::int64_t channels = 5;
  constexpr std::int64_t embedding = 6;
  const DiffusionCase at(test::TinyLatentDiffusion(), 1);
  const std::shared_ptr<const FieldLevel> fine(at.Surface, &at.Surface->Fine);
  const torch::Tensor embeddings = torch::randn({ 4, embedding }, torch::kFloat64);
  NormalizedFieldNeuron neuron(channels, 7);
  FieldConvolution plain(channels, 0, false);
  FieldConvolution guided(channels, embedding, true);
  const auto convolve = [&](FieldConvolution& layer, const torch::Tensor& x) {
    return layer->forward(x, embeddings.to(x.scalar_type()), FieldLevelTensors(fine, true, x));
  };
  ExpectStepsAreExact(*neuron, at, [&](const torch::Tensor& x) { return neuron->forward(x); });
  ExpectStepsAreExact(*plain, at, [&](const torch::Tensor& x) { return convolve(plain, x); });
  ExpectStepsAreExact(*guided, at, [&](const torch::Tensor& x) { return convolve(guided, x); });
}

TEST(LatentDenoisingNetwork, HasTheDerivativesOfTheExpressions)
{
  const LatentDiffusionModel model = test::RandomLatentDiffusion();
  DiffusionCase at(model.Options, 1);
  const LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  // Rounding that moves one neuron to the other side of its kink changes derivatives by per cents. It does so at few
  // states, and where depends on the processor, so the median of the states counts: a wrong step is wrong at all.
  constexpr int states = 7;
  const FieldLatentMatrix first = at.State;
  std::map<std::string, std::vector<double>> differences;
  for (int k = 0; k < states; ++k)
  {
    at.State = (1.0F + 0.1F * static_cast<float>(k)) * first;
    const auto steps = Derivatives(network, at, torch::kFloat32);
    const auto expressions = Derivatives(network, at, torch::kFloat64);
    ASSERT_EQ(steps.size(), expressions.size());
    for (const auto& [name, expected] : expressions)
    {
      EXPECT_GT(expected.abs().max().item<double>(), 1e-6) << name;
      differences[name].push_back(RelativeDifference(steps.at(name), expected));
    }
  }
  for (auto& [name, found] : differences)
  {
    std::nth_element(found.begin(), found.begin() + states / 2, found.end());
    // Each step is exact to 1e-5; forty of them with random weights are conditioned worse.
    EXPECT_LT(found[states / 2], 1e-3) << name;
  }
}

TEST(LatentDenoisingNetwork, DerivativesAreThoseOfDifferences)
{
  const LatentDiffusionModel model = test::RandomLatentDiffusion();
  const DiffusionCase at(model.Options, 1);
  const LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  const auto derivatives = Derivatives(network, at, torch::kFloat64);
  const torch::NoGradGuard noGradients;
  const torch::Tensor state = at.StateTensor(torch::kFloat64);
  const torch::Tensor weights = torch::sin(torch::arange(state.numel(), torch::kFloat64)).view(state.sizes());
  const auto value = [&] {
    LatentDenoisingNetwork evaluated = network;
    return (evaluated->forward(state, 12.0, at.Surface) * weights).sum().item<double>();
  };
  constexpr double step = 1e-8; // no ReLU comes to its other side
  for (auto& parameter : network->named_parameters())
  {
    torch::Tensor tensor = parameter.value();
    const torch::Tensor along = torch::cos(1.7 * torch::arange(tensor.numel(), torch::kFloat64)).view(tensor.sizes());
    tensor.add_(along, step);
    const double above = value();
    tensor.sub_(along, 2.0 * step);
    const double below = value();
    tensor.add_(along, step);
    const double expected = (above - below) / (2.0 * step);
    const double found = (derivatives.at(parameter.key()) * along).sum().item<double>();
    const double size = derivatives.at(parameter.key()).norm().item<double>();
    EXPECT_NEAR(found, expected, 1e-5 * size + 1e-8) << parameter.key();
  }
}

TEST(LatentDenoisingNetwork, EveryNumberOfThreadsGivesTheSameBits)
{
  const LatentDiffusionModel model = test::RandomLatentDiffusion();
  const DiffusionCase at(model.Options, 2);
  const LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  const int threads = at::get_num_threads();
  at::set_num_threads(1);
  const auto one = Derivatives(network, at, torch::kFloat32);
  at::set_num_threads(3);
  const auto three = Derivatives(network, at, torch::kFloat32);
  at::set_num_threads(threads);
  for (const auto& [name, expected] : one)
  {
    EXPECT_TRUE(torch::equal(three.at(name), expected)) << name;
  }
}

TEST(LatentDenoisingNetwork, ResultsThatAreKeptAndThatAreComputedAgainGiveTheSameBits)
{
  const LatentDiffusionModel model = test::RandomLatentDiffusion();
  const DiffusionCase at(model.Options, 2);
  const LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  const auto kept = Derivatives(network, at, torch::kFloat32);
  const std::int64_t bytes = FieldStepMemory().exchange(0);
  const auto again = Derivatives(network, at, torch::kFloat32);
  FieldStepMemory() = bytes;
  for (const auto& [name, expected] : kept)
  {
    EXPECT_TRUE(torch::equal(again.at(name), expected)) << name;
  }
}

TEST(LatentDenoisingNetwork, PoolingAndUnpoolingAreTransposesUpToTheNumbersOfMembers)
{
  const DiffusionCase at(test::TinyLatentDiffusion(), 2);
  const std::int64_t vertices = at.Surface->Fine.NumberOfVertices();
  const std::int64_t coarse = at.Surface->Coarse.NumberOfVertices();
  const torch::Tensor x = torch::sin(torch::arange(vertices * 6, torch::kFloat32)).view({ vertices, 6 });
  const torch::Tensor y = torch::cos(torch::arange(coarse * 6, torch::kFloat32)).view({ coarse, 6 });
  for (const torch::ScalarType type : { torch::kFloat32, torch::kFloat64 })
  {
    // A field that is unpooled and pooled again is the same.
    const torch::Tensor pooled = PoolFields(at.Surface, UnpoolFields(at.Surface, y.to(type)));
    EXPECT_LT(RelativeDifference(pooled, y), 1e-5);
    torch::Tensor input = x.to(type, false, true).requires_grad_(true);
    PoolFields(at.Surface, input).mul(y.to(type)).sum().backward();
    const torch::Tensor other = PoolFields(at.Surface, x.to(torch::kFloat64)).mul(y.to(torch::kFloat64)).sum();
    EXPECT_NEAR((input.grad() * input).sum().item<double>(), other.item<double>(), 1e-4);
  }
}

TEST(LatentDenoisingNetwork, SecondDerivativesAreRefused)
{
  const LatentDiffusionModel model = test::RandomLatentDiffusion();
  const DiffusionCase at(model.Options, 1);
  LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  const torch::Tensor state = at.StateTensor(torch::kFloat32).requires_grad_(true);
  const torch::Tensor sum = network->forward(state, 3.0, at.Surface).square().sum();
  EXPECT_THROW(torch::autograd::grad({ sum }, { state }, {}, true, true), InvalidInput);
}

TEST(LatentDenoisingNetwork, InitialWeightsPredictZero)
{
  const LatentDiffusionModel model = InitialLatentDiffusion(test::TinyLatentDiffusion(), 4);
  const DiffusionCase at(model.Options, 1);
  LatentDenoisingNetwork network = MakeLatentDenoisingNetwork(model);
  EXPECT_EQ(network->forward(at.StateTensor(torch::kFloat32), 3.0, at.Surface).abs().max().item<double>(), 0.0);
  EXPECT_EQ(InitialLatentDiffusion(model.Options, 4).Tensors.at("input.0.mlp1.0.key.weight").Values,
    model.Tensors.at("input.0.mlp1.0.key.weight").Values);
  EXPECT_NE(InitialLatentDiffusion(model.Options, 5).Tensors.at("input.0.mlp1.0.key.weight").Values,
    model.Tensors.at("input.0.mlp1.0.key.weight").Values);
}
