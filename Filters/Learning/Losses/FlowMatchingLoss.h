// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The loss of conditional flow matching on a mesh: equation 12 of "Matérn Noise for Triangulation-Agnostic Flow Matching
/// on Meshes".
#pragma once

#include "Learning/Layers/MeshTensors.h"
#include "Learning/Networks/PoissonNet.h"

#include <torch/torch.h>

namespace surfsynth
{

/// The two terms of the loss, means over batch, surface and components; scalars.
struct FlowMatchingLoss
{
  torch::Tensor Vertex;   ///< sum_i m_i (delta_i - v_i)^2 / (C sum_i m_i)
  torch::Tensor Jacobian; ///< sum_f A_f |grad delta_f - J_f|^2 / (2 C sum_f A_f)
};

/// Compares what a network says with the velocity @p delta = f_1 - f_0 [..., V, C] that it should have said. m are the
/// vertex masses and A the face areas: both terms are integrals over the surface, which do not depend on its
/// triangulation. J are the gradients that a gradient-domain head predicts before it integrates them; those of the
/// velocity itself for a linear head.
FlowMatchingLoss ComputeFlowMatchingLoss(
  const MeshTensors& mesh, const PoissonNetOutput& prediction, const torch::Tensor& delta);

} // namespace surfsynth
