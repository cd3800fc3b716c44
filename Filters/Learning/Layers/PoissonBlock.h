// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Block and gradient-domain head of a PoissonNet [Maesumi2025].
#pragma once

#include "Inference/PoissonNet/PoissonNetOptions.h"
#include "Learning/Layers/ComplexMlp.h"
#include "Learning/Layers/VertexMlp.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Block that maps vertex features x [..., V, W] to new ones. With g = G x,
///   h = ComplexMlp(g),   u = K^-1 G^T A h minus its mean, K = L + shift,
///   p = tanh(s * mean over the faces around of <W h, g>)   when inner products are on,
///   out = VertexMlp(x, u, extra, p).
class PoissonBlockImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  explicit PoissonBlockImpl(const PoissonNetOptions& options);
  /// Computes the new features, [..., V, W].
  /// @param x [..., V, W]
  /// @param extra the embedded condition, [..., V, W], or undefined
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra);

private:
  /// Inputs of the pointwise half that come from the gradients.
  struct FromGradients
  {
    torch::Tensor Solved;   ///< [..., V, W]
    torch::Tensor Products; ///< [..., V, W], or undefined
  };
  FromGradients Plain(const MeshTensors& mesh, const torch::Tensor& x);
  FromGradients Fused(const MeshTensors& mesh, const torch::Tensor& x);

  ComplexMlp GradientMlp{ nullptr };
  ComplexLinear GradientFeatures{ nullptr };
  torch::Tensor GradientScaler;
  VertexMlp Pointwise{ nullptr };
};
TORCH_MODULE(PoissonBlock);

/// Output of GradientDomainHead.
struct IntegratedGradients
{
  torch::Tensor Positions; ///< [..., V, 3], mass-weighted mean 0
  torch::Tensor Gradients; ///< [..., 2 F, 3], rows interleaved
};

/// Head that predicts gradients [Aigerman2022]: face gradients of the features become three complex channels, to which
/// those of the positions are added; the output are the positions that have these gradients, and the gradients.
class GradientDomainHeadImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  explicit GradientDomainHeadImpl(const PoissonNetOptions& options);
  /// Computes the output.
  /// @param x features, [..., V, W]
  /// @param positions [..., V, 3]; detached from the graph of derivatives
  IntegratedGradients forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& positions);

private:
  ComplexMlp GradientMlp{ nullptr };
};
TORCH_MODULE(GradientDomainHead);

} // namespace surfsynth
