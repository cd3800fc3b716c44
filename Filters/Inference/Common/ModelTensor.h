// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tensors of model files.
#pragma once

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The numbers of one tensor of a model, row-major.
struct ModelTensor
{
  std::vector<std::int64_t> Shape;
  std::vector<float> Values;
};

} // namespace surfsynth
