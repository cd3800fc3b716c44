// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The block that a PoissonNet repeats.
#pragma once

#include "Inference/PoissonNet/PoissonNetOptions.h"
#include "Learning/Layers/ComplexMlp.h"
#include "Learning/Layers/VertexMlp.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Vertex features x [..., V, W] to new ones. With g = G x,
///   h = ComplexMlp(g),   u = (L + 1e-6 I)^-1 G^T A h minus its mean,
///   p = tanh(s * mean over the faces around of <W h, g>)   when inner products are on,
///   out = VertexMlp(x, u, extra, p).
class PoissonBlockImpl : public torch::nn::Module
{
public:
  explicit PoissonBlockImpl(const PoissonNetOptions& options);
  /// @param extra [..., V, W] or undefined.
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra);

private:
  ComplexMlp GradientMlp{ nullptr };
  ComplexLinear GradientFeatures{ nullptr };
  torch::Tensor GradientScaler;
  VertexMlp Pointwise{ nullptr };
};
TORCH_MODULE(PoissonBlock);

/// The head that predicts gradients: face gradients of the features become three complex channels, to which those of
/// the positions are added; the output are the positions that have these gradients, and the gradients.
struct IntegratedGradients
{
  torch::Tensor Positions; ///< [..., V, 3], mass-weighted mean 0
  torch::Tensor Gradients; ///< [..., 2 F, 3], rows interleaved
};

class GradientDomainHeadImpl : public torch::nn::Module
{
public:
  explicit GradientDomainHeadImpl(const PoissonNetOptions& options);
  /// @param x [..., V, W] features, @param positions [..., V, 3], through which nothing is differentiated.
  IntegratedGradients forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& positions);

private:
  ComplexMlp GradientMlp{ nullptr };
};
TORCH_MODULE(GradientDomainHead);

} // namespace surfsynth
