// SPDX-License-Identifier: BSD-3-Clause
// Muon: orthogonalized matrices, the size of its steps, and which parameters it moves.
#include "Learning/Training/Muon.h"

#include <gtest/gtest.h>

#include <cmath>

namespace surfsynth
{
namespace
{
torch::Tensor RandomMatrix(std::int64_t rows, std::int64_t columns)
{
  torch::manual_seed(7);
  return torch::randn({ rows, columns }, torch::kFloat64);
}

/// Its gradient is @p gradient.
torch::Tensor Parameter(const torch::Tensor& gradient)
{
  torch::Tensor parameter = torch::zeros_like(gradient);
  parameter.set_requires_grad(true);
  parameter.mutable_grad() = gradient.clone();
  return parameter;
}

TEST(Muon, OrthogonalizedMatricesKeepTheirSingularVectors)
{
  for (const auto& [rows, columns] : { std::pair{ 24, 24 }, { 16, 48 }, { 64, 20 } })
  {
    const torch::Tensor matrix = 1e3 * RandomMatrix(rows, columns);
    const torch::Tensor result = Orthogonalized(matrix);
    const auto [u, singular, v] = torch::svd(matrix);
    const torch::Tensor diagonal = u.t().matmul(result).matmul(v);
    const torch::Tensor values = diagonal.diag();
    // The largest ones; small ones of a square matrix take more steps.
    const auto large = singular / singular.max() > 0.1;
    EXPECT_GT(values.masked_select(large).min().item<double>(), 0.65) << rows;
    EXPECT_LT(values.max().item<double>(), 1.25) << rows;
    EXPECT_LT((diagonal - torch::diag(values)).abs().max().item<double>(), 1e-10) << rows;
  }
  EXPECT_EQ(Orthogonalized(torch::zeros({ 16, 20 })).abs().max().item<double>(), 0.0);
}

TEST(Muon, MatricesWhoseNormUnderflowsBecomeSmallOnes)
{
  for (const double size : { 1e-15, 1e-22, 1e-30, 1e-40 }) // a momentum that no gradient renews passes all of them
  {
    const torch::Tensor result = Orthogonalized((size * RandomMatrix(24, 48)).to(torch::kFloat));
    EXPECT_TRUE(torch::isfinite(result).all().item<bool>()) << size;
    EXPECT_LE(result.abs().max().item<double>(), 1.0) << size;
  }
}

TEST(Muon, StepsAreOfTheSizeOfTheLearningRateAndAgainstTheGradient)
{
  const torch::Tensor gradient = RandomMatrix(32, 64);
  for (const double factor : { 1e-4, 1e4 }) // however large the gradient is
  {
    const torch::Tensor parameter = Parameter(factor * gradient);
    Muon muon({ parameter });
    muon.Step(0.01);
    const double size = parameter.detach().square().mean().sqrt().item<double>();
    EXPECT_NEAR(size, 0.2 * 0.01, 0.2 * 0.2 * 0.01);
    EXPECT_LT((parameter.detach() * gradient).sum().item<double>(), 0.0);
  }
}

TEST(Muon, TheMomentumIsTheRunningMeanOfTheGradients)
{
  const torch::Tensor gradient = RandomMatrix(16, 16);
  const torch::Tensor parameter = Parameter(gradient);
  const torch::Tensor still = torch::zeros({ 16, 16 }, torch::kFloat64);
  Muon muon({ still, parameter });
  muon.Step(0.1);
  muon.Step(0.1);
  const torch::Tensor expected = (1.0 - 0.95 * 0.95) * gradient;
  EXPECT_LT((muon.MomentumOf(parameter) - expected).abs().max().item<double>(), 1e-12);
  EXPECT_EQ(still.abs().max().item<double>(), 0.0) << "it has no gradient";
}

TEST(Muon, MatricesInsideANetworkAreMovedAndTheRestIsNot)
{
  EXPECT_TRUE(Muon::Moves(torch::zeros({ 16, 16 })));
  EXPECT_TRUE(Muon::Moves(torch::zeros({ 48, 144 })));
  EXPECT_FALSE(Muon::Moves(torch::zeros({ 48, 4 }))) << "a first map";
  EXPECT_FALSE(Muon::Moves(torch::zeros({ 3, 48 }))) << "a last map";
  EXPECT_FALSE(Muon::Moves(torch::zeros({ 48 }))) << "a bias";
}

} // namespace
} // namespace surfsynth
