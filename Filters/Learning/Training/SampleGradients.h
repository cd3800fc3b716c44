// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Gradients of a loss that is a sum over samples, one sample on each thread. Private to the training.
#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// True when a batch of @p samples on a device is better taken apart by AddSampleGradients() than as a whole, whose steps
/// divide each layer among the threads: on the processor, with at least a sample for each thread of torch.
bool ServesSampleGradients(const torch::Device& device, std::int64_t samples);

/// Calls loss(k) for each of @p samples samples, on as many threads as torch may use, and adds the derivatives of its
/// result, a scalar, to the gradients of @p parameters. A sample is computed by one thread from its loss to its gradients,
/// which are added up in the order of the samples: the same bits for every number of threads.
/// @throws what loss() throws
void AddSampleGradients(const std::vector<torch::Tensor>& parameters, std::int64_t samples,
  const std::function<torch::Tensor(std::int64_t)>& loss);

} // namespace surfsynth
