// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A denoising network for field latents [Mitchel2024], and its file. No torch.
#pragma once

#include "Inference/Common/ModelTensor.h"
#include "Inference/FieldLatents/LatentDiffusionOptions.h"

#include <cstdint>
#include <map>
#include <string>

namespace surfsynth
{

/// Denoising network of a diffusion in the space of field latents.
struct LatentDiffusionModel
{
  LatentDiffusionOptions Options;              ///< architecture
  std::map<std::string, ModelTensor> Tensors;  ///< exactly those of ExpectedLatentDiffusionTensors()
  std::int64_t Iterations = 0;                 ///< iterations of its training; 0 when unknown
  std::string Autoencoder;                     ///< Fingerprint() of the model of its latents; "" when unknown
  std::int64_t TrainingPoints = 0;             ///< mean number of vertices of the training surfaces; 0 when unknown
  std::map<std::string, std::string> Metadata; ///< metadata of the file, unchanged

  std::string Description() const; ///< description in one line: sizes, labels, directions, target, iterations
};

/// Checks a model.
/// @throws InvalidInput naming the parts that do not fit together.
void CheckModel(const LatentDiffusionModel& model);

/// Reads a model file: safetensors with the metadata `architecture` ("field_latent_diffusion"), `format_version` ("1"),
/// `field_latent_diffusion` (a JSON object with the numbers latent_dimension, channels, coarse_channels, input_blocks,
/// coarse_blocks, output_blocks, embedding_dimension, labels, directed (0 or 1), time_steps, first_variance,
/// last_variance, iterations and the string target, "noise", "data" or "velocity"; optionally the number
/// training_points), the tensors of ExpectedLatentDiffusionTensors() and optionally the metadata `autoencoder`, a
/// Fingerprint().
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a number is
/// not finite; ModelMismatch when it is another kind of model.
LatentDiffusionModel ReadLatentDiffusion(const std::string& path);

/// Writes a model file in float32.
/// @throws InvalidInput as CheckModel(), and when the file cannot be written.
void WriteLatentDiffusion(const std::string& path, const LatentDiffusionModel& model);

} // namespace surfsynth
