// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Networks with random weights.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"

#include <cstdint>

namespace surfsynth::test
{

/// Weights uniform in +-1 / sqrt(inputs), for biases in +-1 / sqrt(their number): about as after initialisation.
PoissonNetModel RandomModel(const PoissonNetOptions& options, std::uint64_t seed = 1);

} // namespace surfsynth::test
