// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Denoising network of field latents [Mitchel2024] with LibTorch: differentiable, for training.
#pragma once

#include "Inference/FieldLatents/LatentDiffusionModel.h"
#include "Learning/Layers/LatentDiffusionLayers.h"

#include <torch/torch.h>

#include <cstdint>
#include <memory>

namespace surfsynth
{

/// The network of LatentDiffusionNetwork. Names and shapes of the parameters are those of
/// ExpectedLatentDiffusionTensors(), but for latent_scale.
class LatentDenoisingNetworkImpl : public torch::nn::Module
{
public:
  /// Registers the parameters of the convolutions without values; see MakeLatentDenoisingNetwork().
  /// @throws InvalidInput as CheckOptions().
  explicit LatentDenoisingNetworkImpl(const LatentDiffusionOptions& options);
  /// Evaluates the network.
  /// @param state [V, 2 d], real and imaginary part of each scaled tangent vector in turn
  /// @param time 0 to T
  /// @param guided false to leave out the labels and directions of @p surface
  /// @return [V, 2 d], what LatentDiffusionOptions::Target says
  torch::Tensor forward(const torch::Tensor& state, double time, const std::shared_ptr<const DiffusionSurface>& surface,
    bool guided = true);

private:
  torch::Tensor Embeddings(double time, const torch::Tensor& like);

  LatentDiffusionOptions Options;
  torch::nn::Sequential Time;
  torch::Tensor Labels; ///< undefined without
  ComplexMap Input{ nullptr };
  ComplexMap Output{ nullptr };
  TimeGains InputGains{ nullptr };
  TimeGains OutputGains{ nullptr };
  std::vector<FieldResidualBlock> InputBlocks;
  std::vector<FieldResidualBlock> CoarseBlocks;
  std::vector<FieldResidualBlock> OutputBlocks;
};
TORCH_MODULE(LatentDenoisingNetwork);

/// Makes the network of a model, in float32 on the processor.
/// @throws InvalidInput as CheckModel().
LatentDenoisingNetwork MakeLatentDenoisingNetwork(const LatentDiffusionModel& model);

} // namespace surfsynth
