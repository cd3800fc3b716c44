// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tensors of model files.
#pragma once

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// One tensor of a model.
struct ModelTensor
{
  std::vector<std::int64_t> Shape; ///< empty for a single number
  std::vector<float> Values;       ///< row-major
};

} // namespace surfsynth
