// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/GeometricTextureLosses.h"

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

torch::Tensor ReconstructionLoss(const torch::Tensor& positions, const torch::Tensor& reference)
{
  return torch::mse_loss(positions, reference);
}

} // namespace surfsynth
