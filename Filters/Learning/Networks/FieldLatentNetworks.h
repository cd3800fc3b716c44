// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Encoder and decoder of field latents [Mitchel2024] with LibTorch: differentiable, for training.
#pragma once

#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Learning/Layers/FieldLatentLayers.h"

#include <torch/torch.h>

#include <map>
#include <string>

namespace surfsynth
{

/// Gaussians in the tangent spaces of R vertices.
struct FieldLatentGaussians
{
  torch::Tensor Mean;         ///< [R, d, 2], real and imaginary part
  torch::Tensor LogDeviation; ///< [R, d]
};

/// One VN-transformer layer: norm1, attention, sum; norm2, neuron1, neuron2, sum.
class FieldLatentTransformerImpl : public torch::nn::Module
{
public:
  /// Initializes the layers.
  FieldLatentTransformerImpl(std::int64_t channels, std::int64_t heads);
  /// Maps [R, T, 2 C] to the same shape.
  torch::Tensor forward(const torch::Tensor& x);
  /// The last token of each ring after the layer, [R, 2 C], without the rest of the others.
  torch::Tensor LastToken(const torch::Tensor& x);

private:
  RingNorm Norm1{ nullptr };
  RingAttention Attention{ nullptr };
  RingNorm Norm2{ nullptr };
  VectorNeuron Neuron1{ nullptr };
  VectorNeuron Neuron2{ nullptr };
};
TORCH_MODULE(FieldLatentTransformer);

/// Encoder; see FieldLatentEncoder for what the paper leaves open.
class FieldLatentEncoderNetworkImpl : public torch::nn::Module
{
public:
  /// Initializes the layers.
  explicit FieldLatentEncoderNetworkImpl(const FieldLatentOptions& options);
  /// Encodes rings of the same number N of samples.
  /// @param logarithms [R, N, 2]
  /// @param colors [R, N, 3]
  FieldLatentGaussians forward(const torch::Tensor& logarithms, const torch::Tensor& colors);

private:
  torch::Tensor Features(const torch::Tensor& logarithms, const torch::Tensor& colors);

  torch::nn::Linear Lift{ nullptr };
  torch::nn::Linear Gather{ nullptr };
  torch::nn::Sequential Filter;
  torch::nn::ModuleList Layers;
  VectorNeuron MeanNeuron{ nullptr };
  ComplexMap MeanOut{ nullptr };
  ComplexMap Product{ nullptr };
  torch::nn::Linear DeviationIn{ nullptr };
  torch::nn::Linear DeviationOut{ nullptr };
};
TORCH_MODULE(FieldLatentEncoderNetwork);

/// Decoder; see FieldLatentDecoder.
class FieldLatentDecoderNetworkImpl : public torch::nn::Module
{
public:
  /// Initializes the layers.
  explicit FieldLatentDecoderNetworkImpl(const FieldLatentOptions& options);
  /// Predictions from the perspective of one vertex each, for logarithmic coordinates: [R, N, 3].
  /// @param latents [R, d, 2]
  /// @param logarithms [R, N, 2]
  torch::Tensor forward(const torch::Tensor& latents, const torch::Tensor& logarithms);
  /// Predictions in triangles, for barycentric coordinates: [B, N, 3].
  /// @param latents [B, 3, d, 2], of the corners
  /// @param barycentric [B, N, 3]
  torch::Tensor Blended(const torch::Tensor& latents, const torch::Tensor& barycentric);

private:
  torch::Tensor FieldOf(const torch::Tensor& first);

  std::int64_t Coordinates; ///< inputs of equation 5
  torch::nn::ModuleList Layers;
};
TORCH_MODULE(FieldLatentDecoderNetwork);

/// Both networks, named encoder and decoder: names and shapes of the parameters are those of
/// ExpectedFieldLatentTensors().
class FieldLatentNetworkImpl : public torch::nn::Module
{
public:
  /// Initializes the networks.
  /// @throws InvalidInput as CheckOptions().
  explicit FieldLatentNetworkImpl(const FieldLatentOptions& options);

  FieldLatentEncoderNetwork Encoder{ nullptr }; ///< first half
  FieldLatentDecoderNetwork Decoder{ nullptr }; ///< second half
};
TORCH_MODULE(FieldLatentNetwork);

/// Numbers of the upper triangle of z z^* of codes [..., d, 2]: [..., d (d + 1)], real parts, then imaginary parts.
torch::Tensor LatentProducts(const torch::Tensor& latents);

/// Equation 5 for codes [R, d, 2] and logarithms [R, N, 2]: [R, N, 2 d], real parts, then imaginary parts.
torch::Tensor LatentCoordinates(const torch::Tensor& latents, const torch::Tensor& logarithms);

/// Makes the networks of a model, in float32 on the processor.
/// @throws InvalidInput as CheckModel().
FieldLatentNetwork MakeFieldLatentNetwork(const FieldLatentModel& model);

} // namespace surfsynth
