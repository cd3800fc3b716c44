// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Steps of the denoising network of field latents [Mitchel2024] on the processor in float32, each with a derivative of
/// its own (first derivatives only). Private to Learning.
///
/// They keep their inputs, and sums of neighborhoods and products of neurons where FieldStepMemory() holds those of a layer;
/// filters, and larger sums and products, are computed again for the derivatives, one tile of vertices at a time. Results and derivatives have the same bits for every number of threads.
#pragma once

#include "Learning/Layers/DiffusionSurface.h"

#include <torch/torch.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Most bytes of the intermediate results of one step that are kept for its derivatives, 32 MiB: reading them takes less
/// time than computing them again. More would take memory that grows with the surface and the layers. The bits of results
/// do not depend on it.
std::atomic<std::int64_t>& FieldStepMemory();

/// Computes equations 20, with the mean over all vertices, and 19 on [V, 2 a]: [V, 2 b].
/// @param scale [2, a] @param logDelta [a] @param key, query [2, b, a]
torch::Tensor FusedFieldNeuron(const torch::Tensor& x, const torch::Tensor& scale, const torch::Tensor& logDelta,
  const torch::Tensor& key, const torch::Tensor& query);

/// Inputs of a field convolution: features [V, 2 C], shares [*, 8] (bias and embedding in the first layer of the filter),
/// then its weights, shapes as in ExpectedLatentDiffusionTensors().
enum ConvolutionInput
{
  InputX,
  InputShares,
  InputRadius,
  InputAligned,
  InputCentroids,
  InputDirected,
  InputHidden,
  InputHiddenBias,
  InputWeight,
  ConvolutionInputs
};

/// Computes equation 35. @param in by ConvolutionInput @param guided false to leave out labels and directions
torch::Tensor FusedFieldConvolution(
  const std::shared_ptr<const FieldLevel>& level, bool guided, const std::vector<torch::Tensor>& in);

/// Carries features between the levels: the sum over the members of each cluster in the frame of its center, or the
/// features of the center in the frames of the members.
/// @param toCoarse true for the sum @param mean true to divide by the number of members
torch::Tensor FusedClusterCarry(
  const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& x, bool toCoarse, bool mean);

/// Refuses second derivatives: only their computation records a backward pass. @throws InvalidInput
void RequireFirstFieldDerivatives();

} // namespace surfsynth
