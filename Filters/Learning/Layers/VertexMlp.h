// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers on vertex features.
#pragma once

#include "Learning/Layers/MeshTensors.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Per-channel norm over the vertices of a mesh: (x - mean) / sqrt(variance + 1e-12), then an affine map of each
/// channel. The variance is biased. When mass-weighted, sums are weighted by mass and divided by the total mass +
/// 1e-12.
struct VertexNormOptions
{
  explicit VertexNormOptions(std::int64_t channels)
    : channels_(channels)
  {}
  TORCH_ARG(std::int64_t, channels);
  TORCH_ARG(bool, mass_weighted) = false;
};

class VertexNormImpl : public torch::nn::Module
{
public:
  explicit VertexNormImpl(const VertexNormOptions& options);
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& signal);

private:
  bool MassWeighted;
  torch::Tensor Weight;
  torch::Tensor Bias;
};
TORCH_MODULE(VertexNorm);

/// affine, GELU, dropout, affine.
class TwoLayerMlpImpl : public torch::nn::Module
{
public:
  TwoLayerMlpImpl(std::int64_t inputs, std::int64_t width, double dropout);
  torch::Tensor forward(const torch::Tensor& x) { return this->Layers->forward(x); }

private:
  torch::nn::Sequential Layers{ nullptr };
};
TORCH_MODULE(TwoLayerMlp);

/// The pointwise half of a block: with c = [x, u, extra, inner products],
///   y = x + l1 * affine(GELU(affine(c))),   out = y + l2 * affine(GELU(affine(y))).
struct VertexMlpOptions
{
  VertexMlpOptions(std::int64_t width, std::int64_t inputs)
    : width_(width)
    , inputs_(inputs)
  {}
  TORCH_ARG(std::int64_t, width);
  TORCH_ARG(std::int64_t, inputs);    ///< channels of c
  TORCH_ARG(bool, normalise) = false; ///< u and the inner products pass a VertexNorm
  TORCH_ARG(bool, inner_products) = false;
  TORCH_ARG(bool, mass_weighted_norm) = false;
  TORCH_ARG(double, dropout) = 0.0; ///< before the second affine map of each half; in training only
};

class VertexMlpImpl : public torch::nn::Module
{
public:
  explicit VertexMlpImpl(const VertexMlpOptions& options);
  /// @param x, @param solved [..., V, width]; @param extra, @param innerProducts the same, or undefined.
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& solved,
    const torch::Tensor& extra, const torch::Tensor& innerProducts);

private:
  torch::Tensor Scale1;
  torch::Tensor Scale2;
  TwoLayerMlp Mlp1{ nullptr };
  TwoLayerMlp Mlp2{ nullptr };
  VertexNorm SolutionNorm{ nullptr };
  VertexNorm ProductNorm{ nullptr };
};
TORCH_MODULE(VertexMlp);

} // namespace surfsynth
