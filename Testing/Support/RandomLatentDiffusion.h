// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Denoising networks of field latents with random weights.
#pragma once

#include "Inference/FieldLatents/LatentDiffusionModel.h"

#include <cstdint>

namespace surfsynth::test
{

/// Dimension 2, 5 and 18 channels, 1 + 2 + 1 blocks, embeddings of 6 numbers, 3 labels, directed, 100 time steps.
LatentDiffusionOptions TinyLatentDiffusion();

/// Weights uniform in +-sqrt(3 / inputs), norms near 1.
LatentDiffusionModel RandomLatentDiffusion(
  const LatentDiffusionOptions& options = TinyLatentDiffusion(), std::uint64_t seed = 1);

} // namespace surfsynth::test
