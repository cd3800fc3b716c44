// SPDX-License-Identifier: BSD-3-Clause
// Muon for complex matrices: steps commute with turns, and other parameters and optimizers are left alone.
#include "Learning/Training/ComplexMuon.h"

#include <gtest/gtest.h>

#include <cmath>

namespace surfsynth
{
namespace
{

torch::Tensor RandomParts(std::vector<std::int64_t> shape)
{
  torch::manual_seed(7);
  return torch::randn(shape, torch::kFloat64);
}

torch::Tensor ZeroWith(const torch::Tensor& gradient)
{
  torch::Tensor parameter = torch::zeros_like(gradient).requires_grad_(true);
  parameter.mutable_grad() = gradient.clone();
  return parameter;
}

/// Product with exp(i angle) of complex numbers in two parts.
torch::Tensor Turned(const torch::Tensor& parts, double angle)
{
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return torch::stack({ c * parts[0] - s * parts[1], s * parts[0] + c * parts[1] });
}

/// A parameter after one step from 0 along a gradient.
torch::Tensor AfterStep(const torch::Tensor& gradient)
{
  const torch::Tensor parameter = ZeroWith(gradient);
  ComplexMuon muon({ parameter });
  muon.TakeGradients();
  muon.Step(0.01);
  return parameter.detach();
}

TEST(ComplexMuon, StepsCommuteWithTurns)
{
  for (const auto& shape : { std::vector<std::int64_t>{ 2, 16, 24 }, { 2, 20, 8, 16 } })
  {
    const torch::Tensor gradient = RandomParts(shape);
    const torch::Tensor step = AfterStep(gradient);
    EXPECT_LT((AfterStep(Turned(gradient, 0.8)) - Turned(step, 0.8)).abs().max().item<double>(), 1e-12);
    EXPECT_NEAR(step.square().mean().sqrt().item<double>(), 0.2 * 0.01, 0.2 * 0.2 * 0.01);
    EXPECT_LT((step * gradient).sum().item<double>(), 0.0);
  }
}

TEST(ComplexMuon, OnlyMatricesInsideTheNetworkMoveAndTheirGradientsAreTaken)
{
  const torch::Tensor matrix = ZeroWith(RandomParts({ 2, 16, 16 }));
  const torch::Tensor last = ZeroWith(RandomParts({ 2, 8, 32 }));
  EXPECT_TRUE(ComplexMuon::Moves(matrix));
  EXPECT_FALSE(ComplexMuon::Moves(last)) << "a last map";
  EXPECT_FALSE(ComplexMuon::Moves(torch::zeros({ 2, 32, 10 }))) << "a first map";
  EXPECT_FALSE(ComplexMuon::Moves(torch::zeros({ 32, 32 }))) << "a real map";
  ComplexMuon muon({ last, matrix });
  muon.TakeGradients();
  EXPECT_EQ(matrix.grad().abs().max().item<double>(), 0.0);
  EXPECT_GT(last.grad().abs().max().item<double>(), 0.0);
  muon.Step(0.1);
  EXPECT_GT(matrix.abs().max().item<double>(), 0.0);
  EXPECT_EQ(last.abs().max().item<double>(), 0.0);
}

TEST(ComplexMuon, AMomentumThatIsSetGivesTheBitsOfTheNextStep)
{
  const torch::Tensor gradient = RandomParts({ 2, 16, 2, 9 });
  const torch::Tensor first = ZeroWith(gradient);
  ComplexMuon muon({ first });
  muon.TakeGradients();
  muon.Step(0.1);
  const torch::Tensor second = ZeroWith(gradient);
  ComplexMuon resumed({ second });
  second.detach().copy_(first);
  resumed.SetMomentum(second, muon.MomentumOf(first));
  EXPECT_LT((resumed.MomentumOf(second) - 0.05 * gradient).abs().max().item<double>(), 1e-12);
  for (auto* each : { &muon, &resumed })
  {
    const torch::Tensor& parameter = each == &muon ? first : second;
    parameter.grad().copy_(2.0 * gradient);
    each->TakeGradients();
    each->Step(0.1);
  }
  EXPECT_TRUE(second.equal(first));
}

} // namespace
} // namespace surfsynth
