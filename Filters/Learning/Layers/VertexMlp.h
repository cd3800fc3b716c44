// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers on vertex features [Maesumi2025].
#pragma once

#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/MeshTensors.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Options of VertexNorm.
struct VertexNormOptions
{
  /// @param channels number of channels
  explicit VertexNormOptions(std::int64_t channels)
    : channels_(channels)
  {}
  TORCH_ARG(std::int64_t, channels);      ///< number of channels
  TORCH_ARG(bool, mass_weighted) = false; ///< weighs vertices by their mass
};

/// Per-channel norm over the vertices of a mesh: (x - mean) / sqrt(variance + 1e-12), then an affine map of each
/// channel. The variance is biased. When mass-weighted, sums are weighted by mass and divided by the total mass +
/// 1e-12.
class VertexNormImpl : public torch::nn::Module
{
public:
  /// Initialises the affine map with the identity.
  explicit VertexNormImpl(const VertexNormOptions& options);
  /// Normalises @p signal, [..., V, channels].
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& signal);

private:
  bool MassWeighted;
  torch::Tensor Weight;
  torch::Tensor Bias;
};
TORCH_MODULE(VertexNorm);

/// MLP of two layers: affine, GELU, dropout, affine.
class TwoLayerMlpImpl : public torch::nn::Module
{
public:
  /// @param inputs number of input channels
  /// @param width number of hidden and output channels
  /// @param dropout probability, [0, 1)
  TwoLayerMlpImpl(std::int64_t inputs, std::int64_t width, double dropout);
  /// Maps [..., inputs] to [..., width].
  torch::Tensor forward(const torch::Tensor& x) { return this->Layers->forward(x); }
  /// First or second affine map. @param k 0 or 1
  torch::nn::LinearImpl& Map(std::size_t k) { return *this->Layers[3 * k]->as<torch::nn::Linear>(); }

private:
  torch::nn::Sequential Layers{ nullptr };
};
TORCH_MODULE(TwoLayerMlp);

/// Options of VertexMlp.
struct VertexMlpOptions
{
  /// @param width number of channels of the features
  /// @param inputs number of channels of c
  VertexMlpOptions(std::int64_t width, std::int64_t inputs)
    : width_(width)
    , inputs_(inputs)
  {}
  TORCH_ARG(std::int64_t, width);              ///< channels of the features
  TORCH_ARG(std::int64_t, inputs);             ///< channels of c
  TORCH_ARG(bool, normalize) = false;          ///< u and the inner products pass a VertexNorm
  TORCH_ARG(bool, inner_products) = false;     ///< c has inner products
  TORCH_ARG(bool, mass_weighted_norm) = false; ///< see VertexNormOptions
  TORCH_ARG(double, dropout) = 0.0;            ///< before the second affine map of each half; in training only
};

/// Pointwise half of a block: with c = [x, u, extra, inner products],
///   y = x + l1 * affine(GELU(affine(c))),   out = y + l2 * affine(GELU(affine(y))).
class VertexMlpImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  explicit VertexMlpImpl(const VertexMlpOptions& options);
  /// Computes the new features, [..., V, width].
  /// @param x features, [..., V, width]
  /// @param solved solution u of the Poisson equation, [..., V, width]
  /// @param extra embedded condition, [..., V, width], or undefined
  /// @param innerProducts [..., V, width], or undefined
  torch::Tensor forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& solved,
    const torch::Tensor& extra, const torch::Tensor& innerProducts);

private:
  VertexMlpWeights Weights();

  double Dropout;
  torch::Tensor Scale1;
  torch::Tensor Scale2;
  TwoLayerMlp Mlp1{ nullptr };
  TwoLayerMlp Mlp2{ nullptr };
  VertexNorm SolutionNorm{ nullptr };
  VertexNorm ProductNorm{ nullptr };
};
TORCH_MODULE(VertexMlp);

} // namespace surfsynth
