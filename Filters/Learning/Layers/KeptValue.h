// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Values other than tensors from the forward to the backward pass of a differentiable step. Private to Learning.
#pragma once

#include <torch/torch.h>

#include <utility>

namespace surfsynth
{

/// Holder of a value in the context of a step.
template <typename Value>
struct ValueHolder : torch::CustomClassHolder
{
  explicit ValueHolder(Value value)
    : Held(std::move(value))
  {}
  Value Held;
};

/// Keeps a value, one for each step, for the backward pass.
template <typename Value>
void KeepValue(torch::autograd::AutogradContext* context, const Value& value)
{
  context->saved_data["value"] = c10::IValue::make_capsule(c10::make_intrusive<ValueHolder<Value>>(value));
}

/// Returns the value of KeepValue(), of the same type.
template <typename Value>
Value KeptValue(torch::autograd::AutogradContext* context)
{
  const c10::intrusive_ptr<torch::CustomClassHolder> holder = context->saved_data["value"].toCapsule();
  return static_cast<const ValueHolder<Value>&>(*holder).Held;
}

} // namespace surfsynth
