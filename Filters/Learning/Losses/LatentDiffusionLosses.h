// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Losses of the diffusion of field latents [Mitchel2024], equation 10, for each target of the prediction.
#pragma once

#include "Inference/FieldLatents/LatentDiffusionOptions.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Computes the target from the data Z and the noise epsilon, of the same shape. @param alpha in (0, 1)
torch::Tensor DenoisingTarget(
  DiffusionTarget target, double alpha, const torch::Tensor& data, const torch::Tensor& noise);

/// Factor from the squared error of the target to that of the noise that it means: 1 for the noise, s = alpha / (1 -
/// alpha) for the data, alpha for the velocity.
double NoiseErrorFactor(DiffusionTarget target, double alpha);

/// Weight of the squared error of the target: 1 for @p limit 0, else such that the squared error of the data has the
/// weight min(s, limit) [Hang2023].
double DenoisingWeight(DiffusionTarget target, double alpha, double limit);

} // namespace surfsynth
