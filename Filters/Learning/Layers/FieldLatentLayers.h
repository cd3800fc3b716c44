// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers on tangent vectors of field latents [Mitchel2024], sections 9 and 9.1.
///
/// Features of C complex channels are real tensors [..., 2 C]: real parts of all channels, then imaginary parts. A ring
/// is a row of tokens, [R, T, 2 C] for R rings. On the processor in float32, norm, nonlinearity and attention are single
/// steps with a derivative of their own (first derivatives only); elsewhere expressions of LibTorch.
#pragma once

#include <torch/torch.h>

#include <cstdint>

namespace surfsynth
{

/// Complex linear map without bias. The parameter weight is [2, out, in]: real part, then imaginary part.
class ComplexMapImpl : public torch::nn::Module
{
public:
  /// Initializes real and imaginary part uniformly in +-1 / sqrt(in).
  ComplexMapImpl(std::int64_t in, std::int64_t out);
  /// Maps [..., 2 in] to [..., 2 out].
  torch::Tensor forward(const torch::Tensor& x);

  torch::Tensor Weight; ///< [2, out, in]
};
TORCH_MODULE(ComplexMap);

/// Filter response normalization, equation 20; the mean runs over the tokens of a ring. Parameters: scale [2, C], a; and
/// log_delta [C], ln of delta.
class RingNormImpl : public torch::nn::Module
{
public:
  /// Initializes a with 1 and delta with 1e-6.
  explicit RingNormImpl(std::int64_t channels);
  /// Maps [R, T, 2 C] to the same shape.
  torch::Tensor forward(const torch::Tensor& x);

private:
  torch::Tensor Scale;
  torch::Tensor LogDelta;
};
TORCH_MODULE(RingNorm);

/// Vector neuron, equation 19 with delta = 1e-3: maps named key and query, then the nonlinearity.
class VectorNeuronImpl : public torch::nn::Module
{
public:
  /// Initializes the maps.
  explicit VectorNeuronImpl(std::int64_t channels);
  /// Maps [..., 2 C] to the same shape.
  torch::Tensor forward(const torch::Tensor& x);

private:
  ComplexMap Key{ nullptr };
  ComplexMap Query{ nullptr };
};
TORCH_MODULE(VectorNeuron);

/// Multi-headed attention over the tokens of a ring, with complex maps named query, key, value and out. The softmax takes
/// the real part of <query, key> over sqrt(2 C / heads).
class RingAttentionImpl : public torch::nn::Module
{
public:
  /// Initializes the maps. @param heads divides @p channels
  RingAttentionImpl(std::int64_t channels, std::int64_t heads);
  /// Maps [R, T, 2 C] to the same shape.
  torch::Tensor forward(const torch::Tensor& x);

private:
  std::int64_t Heads;
  ComplexMap Query{ nullptr };
  ComplexMap Key{ nullptr };
  ComplexMap Value{ nullptr };
  ComplexMap Out{ nullptr };
};
TORCH_MODULE(RingAttention);

} // namespace surfsynth
