// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Architecture of the variational autoencoder of field latents [Mitchel2024]. No torch.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Coordinates of a texel that the decoder sees.
enum class FieldLatentCoordinates
{
  /// The paper's: c = log_p(q) conj(z) of equation 5, one prediction from each corner of the triangle, blended by
  /// barycentric coordinates.
  Logarithmic,
  /// The paper's ablation ("FL-VAE Barycentric", section 6.1): the outer products of the corners are blended by
  /// barycentric coordinates and decoded once, without equation 5.
  Barycentric
};

/// Sizes of encoder and decoder. Defaults are the paper's (section 9.1) where it names them.
struct FieldLatentOptions
{
  std::int64_t LatentDimension = 8; ///< d, tangent vectors of a latent code, 1 to 256
  std::int64_t Channels = 128;      ///< C, channels of the encoder, 1 to 4096
  std::int64_t EncoderLayers = 8;   ///< VN-transformer layers, 1 to 256
  std::int64_t Heads = 8;           ///< heads of the attention, divides Channels; the paper names no number
  std::int64_t SamplesPerRing = 64; ///< samples of a one-ring in training, advised in use, 1 to 65536
  std::int64_t DecoderLayers = 5;   ///< hidden layers of the neural field, 1 to 256; a linear layer to RGB follows
  std::int64_t DecoderWidth = 512;  ///< channels of the hidden layers, 1 to 65536
  FieldLatentCoordinates Coordinates = FieldLatentCoordinates::Logarithmic; ///< what the decoder sees of a texel

  /// The sizes of the paper: the defaults.
  static FieldLatentOptions Paper();
  /// Sizes that two processor cores train in hours: 32 channels, 4 layers, 4 heads, 32 samples, decoder 4 x 128.
  static FieldLatentOptions Small();

  /// Real numbers of the upper triangle of z z^*, d (d + 1): real parts, then imaginary parts (those of the diagonal
  /// are 0).
  std::int64_t NumberOfProducts() const { return this->LatentDimension * (this->LatentDimension + 1); }
  /// Inputs of the neural field: 2 d numbers of equation 5 (none with barycentric coordinates), then the products.
  std::int64_t DecoderInputs() const;
};

/// Compares all options.
bool operator==(const FieldLatentOptions& a, const FieldLatentOptions& b);

/// Checks the options.
/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const FieldLatentOptions& options);

/// Text of coordinates in model files and commands: "logarithmic", "barycentric".
std::string NameOf(FieldLatentCoordinates coordinates);

/// Shapes of all tensors, by name. Complex matrices are [2, out, in]: real part, then imaginary part. With C channels
/// and d tangent vectors:
///
/// - encoder.lift.weight [2 C, 3], .bias [2 C]: L1 of equation 21, real parts of all channels first. Its inputs are
///   scalars, so that a bias is equivariant: without one a gray neighborhood would have no features.
/// - encoder.gather.weight [2 C, 3], .bias [2 C]: L2 of equation 22, likewise.
/// - encoder.filter.0.weight [C, 1], .0.bias [C], .2.weight [2 C, C], .2.bias [2 C]: f of equation 22, with SiLU.
/// - encoder.layers.L.norm1 and .norm2: .scale [2, C], a of equation 20, and .log_delta [C], ln of its delta.
/// - encoder.layers.L.attention.query, .key, .value and .out: .weight [2, C, C].
/// - encoder.layers.L.neuron1 and .neuron2: .key.weight and .query.weight [2, C, C], K and Q of equation 19.
/// - encoder.mean.neuron.key.weight, .query.weight [2, C, C], encoder.mean.out.weight [2, d, C]: M1 of equation 24.
/// - encoder.deviation.product.weight [2, C, C]: L3 of equation 25; encoder.deviation.0.weight [C, 2 C], .0.bias [C],
///   .2.weight [d, C], .2.bias [d]: M2.
/// - decoder.layers.K.weight, .bias for K = 0 to DecoderLayers: the neural field; the last has 3 outputs.
std::map<std::string, std::vector<std::int64_t>> ExpectedFieldLatentTensors(const FieldLatentOptions& options);

} // namespace surfsynth
