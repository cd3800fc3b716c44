// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/FieldLatentLosses.h"

namespace surfsynth
{

torch::Tensor ColorLoss(const torch::Tensor& predicted, const torch::Tensor& colors)
{
  return (predicted - colors).abs().sum(-1).mean();
}

torch::Tensor KullbackLeiblerLoss(const FieldLatentGaussians& gaussians)
{
  const torch::Tensor logVariance = 2.0 * gaussians.LogDeviation;
  const torch::Tensor modulus = gaussians.Mean.square().sum(-1);
  return 0.5 * (modulus + logVariance.exp() - 1.0 - logVariance).sum(-1).mean();
}

torch::Tensor SampleLatents(const FieldLatentGaussians& gaussians, const torch::Tensor& noise)
{
  return gaussians.Mean + gaussians.LogDeviation.exp().unsqueeze(-1) * noise;
}

} // namespace surfsynth
