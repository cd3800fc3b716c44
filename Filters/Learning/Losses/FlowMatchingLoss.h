// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Loss of conditional flow matching [Lipman2023] on a mesh: [Kuai2026], equation 12.
#pragma once

#include "Learning/Layers/MeshTensors.h"
#include "Learning/Networks/PoissonNet.h"

#include <torch/torch.h>

namespace surfsynth
{

/// The two terms of the loss of each sample, means over surface and components, of the leading dimensions of the target.
struct FlowMatchingLoss
{
  torch::Tensor Vertex;   ///< sum_i m_i (delta_i - v_i)^2 / (C sum_i m_i)
  torch::Tensor Jacobian; ///< sum_f A_f |grad delta_f - J_f|^2 / (2 C sum_f A_f)
};

/// Computes the loss of a predicted velocity v. m are the vertex masses and A the face areas: both terms are integrals
/// over the surface, which do not depend on its triangulation. J are the gradients that a gradient-domain head predicts
/// before it integrates them; those of v itself for a linear head.
/// @param prediction output of the network
/// @param delta the target, f_1 - f_0, [..., V, C]
FlowMatchingLoss ComputeFlowMatchingLoss(
  const MeshTensors& mesh, const PoissonNetOutput& prediction, const torch::Tensor& delta);

} // namespace surfsynth
