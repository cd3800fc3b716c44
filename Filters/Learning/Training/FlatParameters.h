// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// All parameters of a network in one array. Private to the training.
#pragma once

#include <torch/torch.h>

namespace surfsynth
{

/// Moves the parameters of a network, and their gradients, into one array each: an optimizer then takes one step instead
/// of one for each of hundreds of small tensors. The network must not be moved or converted afterwards.
class FlatParameters
{
public:
  /// Moves the parameters, which are all of one type and on one device.
  explicit FlatParameters(torch::nn::Module& network)
  {
    const torch::NoGradGuard noGradients;
    std::vector<torch::Tensor> parts;
    for (const torch::Tensor& parameter : network.parameters())
    {
      parts.push_back(parameter.detach().reshape({ -1 }));
    }
    this->All = torch::cat(parts);
    this->Gradients = torch::zeros_like(this->All);
    std::int64_t first = 0;
    for (torch::Tensor& parameter : network.parameters())
    {
      parameter.set_data(this->All.narrow(0, first, parameter.numel()).view(parameter.sizes()));
      parameter.mutable_grad() = this->Gradients.narrow(0, first, parameter.numel()).view(parameter.sizes());
      first += parameter.numel();
    }
    this->All.mutable_grad() = this->Gradients;
  }

  /// All parameters; its gradient holds theirs.
  const torch::Tensor& Values() const { return this->All; }
  /// Sets all gradients to 0.
  void ZeroGradients() { this->Gradients.zero_(); }
  /// Scales the gradients to a norm of at most @p limit; 0: no limit. Returns their norm before.
  double ClipGradients(double limit)
  {
    const double norm = this->Gradients.norm().item<double>();
    if (limit > 0.0 && norm > limit)
    {
      this->Gradients.mul_(limit / norm);
    }
    return norm;
  }

private:
  torch::Tensor All;
  torch::Tensor Gradients;
};

} // namespace surfsynth
