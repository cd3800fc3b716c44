// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Losses of field latents [Mitchel2024], equations 26 to 28.
#pragma once

#include "Learning/Networks/FieldLatentNetworks.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Equation 26: the sum of the absolute differences of the three colors, averaged over all points.
/// @param predicted [..., 3]
/// @param colors [..., 3]
torch::Tensor ColorLoss(const torch::Tensor& predicted, const torch::Tensor& colors);

/// Equation 27 with its sign turned, so that it is minimized: 1/2 sum over d of |m|^2 + s^2 - 1 - ln s^2, averaged over
/// the rings. The divergence of two-dimensional Gaussians with deviation s of each component is 1/2 (|m|^2 + 2 s^2 - 2 -
/// 2 ln s^2) instead; both are 0 for m = 0 and s = 1 only, and the weight of the paper belongs to the former.
torch::Tensor KullbackLeiblerLoss(const FieldLatentGaussians& gaussians);

/// Samples m + s e with e [R, d, 2] standard normal.
torch::Tensor SampleLatents(const FieldLatentGaussians& gaussians, const torch::Tensor& noise);

} // namespace surfsynth
