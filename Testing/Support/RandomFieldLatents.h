// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field latents with random weights, rings and texels.
#pragma once

#include "Inference/FieldLatents/FieldLatentDecoder.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/FieldLatentModel.h"

#include <cstdint>

namespace surfsynth::test
{

/// Dimension 3, 12 channels, 2 layers, 3 heads, 6 samples, decoder 2 x 10.
FieldLatentOptions TinyFieldLatents();

/// Weights uniform in +-1 / sqrt(inputs), norms near 1.
FieldLatentModel RandomFieldLatents(const FieldLatentOptions& options = TinyFieldLatents(), std::uint64_t seed = 1);

/// Rings of @p vertices vertices with samples in the unit disk and colors in [-1, 1].
/// @param samples of each ring
/// @param more samples of ring v beyond that: v modulo this number, for rings of different sizes
FieldLatentRings RandomRings(std::int64_t vertices, std::int64_t samples, std::int64_t more = 1);

/// Codes of @p vertices vertices, [V, 2 d], in [-1, 1].
FieldLatentMatrix RandomLatents(std::int64_t vertices, std::int64_t dimension);

/// Texels of triangles of vertices with near numbers, with logarithms in [-1, 1].
FieldLatentTexels RandomTexels(std::int64_t count, std::int64_t vertices);

} // namespace surfsynth::test
