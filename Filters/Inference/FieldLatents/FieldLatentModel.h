// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained variational autoencoder of field latents [Mitchel2024], and its file. No torch.
#pragma once

#include "Inference/Common/ModelTensor.h"
#include "Inference/FieldLatents/FieldLatentOptions.h"

#include <cstdint>
#include <map>
#include <string>

namespace surfsynth
{

/// Encoder and decoder of field latents: textures as tangent vectors at vertices.
struct FieldLatentModel
{
  FieldLatentOptions Options;                  ///< architecture
  std::map<std::string, ModelTensor> Tensors;  ///< exactly those of ExpectedFieldLatentTensors()
  std::int64_t Iterations = 0;                 ///< iterations of its training; 0 when unknown
  std::map<std::string, std::string> Metadata; ///< metadata of the file, unchanged

  std::string Description() const; ///< description in one line: dimension, sizes, coordinates, iterations
};

/// Checks a model.
/// @throws InvalidInput naming the parts that do not fit together.
void CheckModel(const FieldLatentModel& model);

/// Returns the fingerprint of a model: 16 hexadecimal digits, a 64-bit hash of the names, shapes and numbers of its
/// tensors. A diffusion model names the autoencoder of its latents by it.
std::string Fingerprint(const FieldLatentModel& model);

/// Reads a model file: safetensors with the metadata `architecture` ("field_latents"), `format_version` ("1"),
/// `field_latents` (a JSON object with the numbers latent_dimension, channels, encoder_layers, heads, samples_per_ring,
/// decoder_layers, decoder_width, iterations and the string coordinates, "logarithmic" or "barycentric") and the tensors
/// of ExpectedFieldLatentTensors().
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a number is
/// not finite; ModelMismatch when it is another kind of model.
FieldLatentModel ReadFieldLatents(const std::string& path);

/// Writes a model file in float32.
/// @throws InvalidInput as CheckModel(), and when the file cannot be written.
void WriteFieldLatents(const std::string& path, const FieldLatentModel& model);

} // namespace surfsynth
