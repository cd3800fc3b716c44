// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Initial weights of networks. No torch.
#pragma once

#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <cstdint>
#include <map>
#include <string>

namespace surfsynth
{

/// Makes a PoissonNet before training: affine maps uniformly in +-1 / sqrt(inputs), their biases likewise, magnitude
/// biases 0, layer scales and norms 1, the scale of inner products 0.01, as the framework of the published network
/// initialises it. A pure function of options and seed.
/// @throws InvalidInput as CheckOptions().
PoissonNetModel InitialPoissonNet(const PoissonNetOptions& options, std::uint64_t seed);

/// Makes the tensors of a generator or discriminator of geometric textures before training: weights and biases
/// uniformly in +-1 / sqrt(inputs), as the framework of the published networks initialises them. A pure function of the
/// arguments.
/// @throws InvalidInput as CheckOptions().
std::map<std::string, ModelTensor> InitialGeometricTextureTensors(
  const GeometricTextureOptions& options, bool discriminator, std::uint64_t seed);

/// Makes field latents before training: affine and complex maps uniformly in +-1 / sqrt(inputs), biases likewise, norms
/// with a = 1 and delta = 1e-6. A pure function of options and seed.
/// @throws InvalidInput as CheckOptions().
FieldLatentModel InitialFieldLatents(const FieldLatentOptions& options, std::uint64_t seed);

/// Makes a denoising network before training: matrices uniformly in +-1 / sqrt(inputs), those of filters, which ReLU
/// follow, in +-sqrt(6 / inputs) [He2015]; biases in +-1 / sqrt(inputs), norms with a = 1 and delta = 1e-6. The weights of
/// the last convolution of each block and of the output are 0 ([Dhariwal2021]): blocks begin as the identity, and the
/// network predicts 0. Factors of the latents are 1. A pure function of options and seed.
/// @throws InvalidInput as CheckOptions().
LatentDiffusionModel InitialLatentDiffusion(const LatentDiffusionOptions& options, std::uint64_t seed);

} // namespace surfsynth
