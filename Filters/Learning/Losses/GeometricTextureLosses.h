// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The losses of geometric textures: "Deep Geometric Texture Synthesis" (Hertz et al. 2020, section 4), a Wasserstein GAN
/// with gradient penalty (Gulrajani et al. 2017).
#pragma once

#include "Learning/Networks/GeometricTextureNetworks.h"

#include <torch/torch.h>

namespace surfsynth
{

/// What a discriminator thinks of a mesh, the larger the more real: the mean over the faces of what its network says. A
/// scalar.
/// @param features [F, 12] of EdgeFeatureTensor(), without noise
torch::Tensor CriticValue(
  GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables, const torch::Tensor& features);

/// How far the critic's slope is from 1 between two meshes with the same triangles, in the space of their features: the
/// mean over the faces of (|g_f| - 1)^2, g_f the gradient of the sum of all that the network says with respect to the 12
/// features of face f, at alpha real + (1 - alpha) fake. A scalar, differentiable in the critic's parameters.
/// @param alpha in [0, 1], the same for all faces
torch::Tensor GradientPenalty(GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables,
  const torch::Tensor& real, const torch::Tensor& fake, double alpha);

/// Mean square of the differences of all coordinates. A scalar.
torch::Tensor ReconstructionLoss(const torch::Tensor& positions, const torch::Tensor& reference);

} // namespace surfsynth
