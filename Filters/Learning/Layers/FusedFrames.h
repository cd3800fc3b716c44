// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Features and displacements in frames of edges, as single steps on the processor in float32. Private to Learning.
///
/// As expressions of LibTorch on vectors of three numbers they take longer than the products of a network. Derivatives are summed
/// in the order of the triangles: the same bits for every number of threads. Second derivatives are refused.
#pragma once

#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Computes EdgeFeatureTensor(). @throws InvalidInput from the computation of second derivatives.
torch::Tensor FusedEdgeFeatures(const FaceTables& tables, const torch::Tensor& positions);

/// Computes CornerDisplacement(). @throws InvalidInput from the computation of second derivatives.
torch::Tensor FusedCornerDisplacement(
  const FaceTables& tables, const torch::Tensor& positions, const torch::Tensor& local);

} // namespace surfsynth
