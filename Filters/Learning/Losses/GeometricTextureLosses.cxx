// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/GeometricTextureLosses.h"

#include <tuple>

namespace surfsynth
{

torch::Tensor CriticValue(
  GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables, const torch::Tensor& features)
{
  return critic.forward(tables, features).mean();
}

torch::Tensor GradientPenalty(GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables,
  const torch::Tensor& real, const torch::Tensor& fake, double alpha)
{
  const torch::Tensor between = (alpha * real + (1.0 - alpha) * fake).detach().requires_grad_();
  const torch::Tensor sum = critic.forward(tables, between).sum();
  const bool keepGraph = true;
  const torch::Tensor gradient = torch::autograd::grad({ sum }, { between }, {}, keepGraph, keepGraph)[0];
  return (gradient.norm(2, -1) - 1.0).square().mean();
}

torch::Tensor SlicedWassersteinLoss(
  const torch::Tensor& features, const torch::Tensor& reference, const torch::Tensor& directions)
{
  const auto sorted = [&directions](
                        const torch::Tensor& points) { return std::get<0>(directions.t().matmul(points.t()).sort(1)); };
  return (sorted(features) - sorted(reference)).abs().mean();
}

torch::Tensor AllEdgeOrders(const torch::Tensor& features)
{
  constexpr std::int64_t channelsOfEdge = 4;
  return torch::cat({ features, features.roll(channelsOfEdge, 1), features.roll(2 * channelsOfEdge, 1) }, 0);
}

torch::Tensor ReconstructionLoss(const torch::Tensor& positions, const torch::Tensor& reference)
{
  return torch::mse_loss(positions, reference);
}

} // namespace surfsynth
