// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// PoissonNet [Maesumi2025] with LibTorch: differentiable, for training. PoissonNetEvaluator evaluates the same network
/// several times faster.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"
#include "Inference/PoissonNet/PoissonNetOptions.h"
#include "Learning/Layers/PoissonBlock.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Output of a PoissonNet.
struct PoissonNetOutput
{
  /// [..., V, C], [..., F, C] or [..., C] by the domain of a linear head; [..., V, 3] of a gradient-domain head.
  torch::Tensor Values;
  torch::Tensor Gradients; ///< [..., 2 F, 3] of a gradient-domain head, else undefined
};

/// The network. Names and shapes of parameters are those of ExpectedTensors(). New networks are initialised by
/// LibTorch's generator (torch::manual_seed): affine maps uniformly in +-1 / sqrt(inputs), magnitude biases 0, layer
/// scales 1, the scale of inner products 0.01.
class PoissonNetImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  /// @throws InvalidInput as CheckOptions().
  explicit PoissonNetImpl(const PoissonNetOptions& options);

  /// Evaluates the network.
  /// @param x [..., V, InputChannels]
  /// @param extra the condition: [ExtraFeatures] or [..., 1, ExtraFeatures] for all vertices, or [..., V,
  /// ExtraFeatures]; undefined when there is none.
  /// @throws InvalidInput when a shape is wrong.
  PoissonNetOutput forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra = {});

  /// Architecture of the network.
  const PoissonNetOptions& Options() const { return this->Architecture; }

private:
  torch::Tensor EmbedExtra(const torch::Tensor& x, const torch::Tensor& extra);
  torch::Tensor MapToDomain(const MeshTensors& mesh, const torch::Tensor& logits) const;

  PoissonNetOptions Architecture;
  torch::nn::Sequential ExtraMlp{ nullptr };
  torch::nn::Linear ProjectIn{ nullptr };
  torch::nn::ModuleList Blocks;
  torch::nn::Linear LinearHead{ nullptr };
  GradientDomainHead IntegratingHead{ nullptr };
};
TORCH_MODULE(PoissonNet);

/// Makes the network of a model, in float32 on the processor.
/// @throws InvalidInput as CheckModel().
PoissonNet MakePoissonNet(const PoissonNetModel& model);

/// Copies the network's parameters to a model, rounded to float32; fields other than Options and Tensors are left
/// empty.
PoissonNetModel ModelOf(PoissonNetImpl& network);

} // namespace surfsynth
