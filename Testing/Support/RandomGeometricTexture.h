// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Geometric textures with random weights.
#pragma once

#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <cstdint>

namespace surfsynth::test
{

/// Two levels of four convolutions with 6 and 8 channels, with a discriminator and an icosahedron as the template.
GeometricTextureOptions SmallGeometricTexture();

/// Weights uniform in +-1 / sqrt(inputs) and biases in +-1 / sqrt(their number), but those of the last convolution of a
/// generator a tenth of that.
GeometricTextureModel RandomGeometricTexture(
  const GeometricTextureOptions& options = SmallGeometricTexture(), std::uint64_t seed = 1);

} // namespace surfsynth::test
