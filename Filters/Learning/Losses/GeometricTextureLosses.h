// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Losses of geometric textures: [Hertz2020], section 4, a Wasserstein GAN with gradient penalty [Gulrajani2017]; and the
/// sliced Wasserstein distance [Rabin2011].
#pragma once

#include "Learning/Networks/GeometricTextureNetworks.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Value of the critic (discriminator) for a mesh, larger for real ones: the mean over the faces of its network's
/// output. A scalar.
/// @param features [F, 12] of EdgeFeatureTensor(), without noise
torch::Tensor CriticValue(
  GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables, const torch::Tensor& features);

/// Gradient penalty [Gulrajani2017] between two meshes with the same triangles, in the space of their features: the
/// mean over the faces of (|g_f| - 1)^2, g_f the gradient of the sum of the network's outputs by the 12 features of
/// face f, at alpha real + (1 - alpha) fake. A scalar, differentiable in the critic's parameters.
/// @param real [F, 12], features of the reference
/// @param fake [F, 12], features of the generated mesh
/// @param alpha in [0, 1], the same for all faces
torch::Tensor GradientPenalty(GeometricTextureLevelNetworkImpl& critic, const FaceTables& tables,
  const torch::Tensor& real, const torch::Tensor& fake, double alpha);

/// Sliced Wasserstein-1 distance [Rabin2011] of two sets of as many features: the mean of |a - b| over the features of
/// both sets in the order of their projections a, b on a direction, and over the directions. A scalar, differentiable in
/// @p features.
/// @param features [N, C]
/// @param reference [N, C]
/// @param directions [C, P], of unit length
torch::Tensor SlicedWassersteinLoss(
  const torch::Tensor& features, const torch::Tensor& reference, const torch::Tensor& directions);

/// Edge features in each of the three orders of the edges of a triangle, [3 F, 12], of [F, 12]: as
/// CompareGeometricTextures() compares them.
torch::Tensor AllEdgeOrders(const torch::Tensor& features);

/// Reconstruction loss: mean square of the differences of all coordinates, [V, 3] each. A scalar.
torch::Tensor ReconstructionLoss(const torch::Tensor& positions, const torch::Tensor& reference);

} // namespace surfsynth
