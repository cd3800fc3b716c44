// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers of the denoising network of field latents [Mitchel2024], section 9.2.
///
/// Features of C complex channels at V vertices are real tensors [V, 2 C]: real parts of all channels, then imaginary
/// parts. On the processor in float32, neurons, convolutions and pooling are single steps with a derivative of their own
/// (first derivatives only), which keep their inputs only: filters and sums of neighborhoods are computed again for the
/// derivatives, one tile of vertices at a time, and the only temporary as large as [V, 16 C] is the derivative by the
/// sums of one convolution. Elsewhere they are expressions of LibTorch, those of a convolution computed again likewise.
/// Results and derivatives have the same bits for every number of threads.
#pragma once

#include "Learning/Layers/DiffusionSurface.h"
#include "Learning/Layers/FieldLatentLayers.h"

#include <torch/torch.h>

#include <complex>
#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Tangent vectors of a table [rows, 2] as a tensor of the type and on the device of @p like, a copy.
torch::Tensor TangentPairs(const float* pairs, std::int64_t rows, const torch::Tensor& like);
/// Tangent vectors as complex numbers, likewise.
torch::Tensor TangentPairs(const std::vector<std::complex<float>>& vectors, const torch::Tensor& like);

/// One level of a surface on a device.
struct FieldLevelTensors
{
  /// Makes the tensors where @p like is; none where layers are single steps.
  /// @param guided false to leave out labels and directions
  FieldLevelTensors(std::shared_ptr<const FieldLevel> level, bool guided, const torch::Tensor& like);

  std::shared_ptr<const FieldLevel> Level;
  bool Guided;
  torch::Tensor Sources;    ///< [E]
  torch::Tensor Targets;    ///< [E]
  torch::Tensor Rows;       ///< [E], row of the embeddings of the source
  torch::Tensor Radii;      ///< [E, 1]
  torch::Tensor Logarithms; ///< [E, 2], unit, in the frames of the sources
  torch::Tensor Transport;  ///< [E, 2], times the weights
  torch::Tensor Centroids;  ///< [E, 2], at the sources, in their frames
  torch::Tensor Directions; ///< [E, 2], at the sources, in their frames; undefined without
};

/// Normalization over all vertices (equation 20) and vector neuron (equation 19). Parameters: norm.scale [2, a],
/// norm.log_delta [a], key.weight and query.weight [2, b, a].
class NormalizedFieldNeuronImpl : public torch::nn::Module
{
public:
  /// Registers the parameters, without values.
  NormalizedFieldNeuronImpl(std::int64_t inputs, std::int64_t outputs);
  /// Maps [V, 2 a] to [V, 2 b].
  torch::Tensor forward(const torch::Tensor& x);

private:
  torch::Tensor Scale;
  torch::Tensor LogDelta;
  torch::Tensor Key;
  torch::Tensor Query;
};
TORCH_MODULE(NormalizedFieldNeuron);

/// Field convolution (equation 35) as in LatentDiffusionNetwork. Parameters as in ExpectedLatentDiffusionTensors().
class FieldConvolutionImpl : public torch::nn::Module
{
public:
  /// Registers the parameters, without values.
  /// @param embedding numbers of the embedding, 0 for a convolution that sees neither embedding nor directions
  FieldConvolutionImpl(std::int64_t channels, std::int64_t embedding, bool directed);
  /// Maps [V, 2 C] to the same shape.
  /// @param embeddings [S, e], of vertices without a label, then of each label
  /// @param gains [C], factors of the results; undefined for none
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& embeddings, const FieldLevelTensors& level,
    const torch::Tensor& gains = {});

private:
  torch::Tensor Radius;
  torch::Tensor Aligned;
  torch::Tensor Centroids; ///< undefined without embedding
  torch::Tensor Directed;  ///< undefined without directions
  torch::Tensor Bias;
  torch::Tensor Embedding; ///< undefined without
  torch::Tensor HiddenWeight;
  torch::Tensor HiddenBias;
  torch::Tensor Weight;
};
TORCH_MODULE(FieldConvolution);

/// Real factors of complex channels that depend on the time: 1 + G e with the embedding e. Parameter: weight [C, e].
class TimeGainsImpl : public torch::nn::Module
{
public:
  /// Registers the parameter: gains of 1.
  TimeGainsImpl(std::int64_t channels, std::int64_t embedding);
  /// Factors [C].
  /// @param embeddings [S, e]; that of vertices without a label, the first, counts
  torch::Tensor forward(const torch::Tensor& embeddings);

private:
  torch::Tensor Weight;
};
TORCH_MODULE(TimeGains);

/// FCResNet block: x + gains convolution2(mlp2(convolution1(mlp1(x)))), x mapped by residual where the widths differ.
class FieldResidualBlockImpl : public torch::nn::Module
{
public:
  /// Registers the parameters, without values.
  FieldResidualBlockImpl(std::int64_t inputs, std::int64_t outputs, std::int64_t embedding, bool directed);
  /// Maps [V, 2 a] to [V, 2 b].
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& embeddings, const FieldLevelTensors& level);

private:
  ComplexMap Residual{ nullptr };
  torch::nn::ModuleList Mlp1;
  FieldConvolution Convolution1{ nullptr };
  torch::nn::ModuleList Mlp2;
  FieldConvolution Convolution2{ nullptr };
  TimeGains Gains{ nullptr };
};
TORCH_MODULE(FieldResidualBlock);

/// Mean over the members of each cluster in the frame of its center: [V, 2 C] to [W, 2 C].
torch::Tensor PoolFields(const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& fine);
/// Features of the center of each vertex in the frame of the vertex: [W, 2 C] to [V, 2 C].
torch::Tensor UnpoolFields(const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& coarse);

} // namespace surfsynth
