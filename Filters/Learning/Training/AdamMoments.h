// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The state of LibTorch's Adam [Kingma2015], for checkpoints. Private to the training.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <sstream>
#include <string>
#include <type_traits>

namespace surfsynth
{

/// Moments of Adam for one parameter.
struct AdamMoments
{
  torch::Tensor Mean;   ///< running mean of the gradient
  torch::Tensor Square; ///< running mean of its square
};

/// The key of a parameter in an optimiser's state: a text in LibTorch 1, an address from LibTorch 2 on.
template <typename State>
auto StateKey(const State&, const torch::Tensor& parameter)
{
  if constexpr (std::is_same_v<typename State::key_type, std::string>)
  {
    std::ostringstream text;
    text << parameter.unsafeGetTensorImpl();
    return text.str();
  }
  else
  {
    return static_cast<typename State::key_type>(parameter.unsafeGetTensorImpl());
  }
}

/// Undefined tensors before the first step.
inline AdamMoments GetMoments(torch::optim::Adam& adam, const torch::Tensor& parameter)
{
  const auto& state = adam.state();
  const auto found = state.find(StateKey(state, parameter));
  if (found == state.end())
  {
    return {};
  }
  const auto& moments = static_cast<const torch::optim::AdamParamState&>(*found->second);
  return { moments.exp_avg(), moments.exp_avg_sq() };
}

inline void SetMoments(
  torch::optim::Adam& adam, const torch::Tensor& parameter, const AdamMoments& moments, std::int64_t step)
{
  auto state = std::make_unique<torch::optim::AdamParamState>();
  state->step(step);
  state->exp_avg(moments.Mean);
  state->exp_avg_sq(moments.Square);
  adam.state()[StateKey(adam.state(), parameter)] = std::move(state);
}

} // namespace surfsynth
