// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Architecture of a denoising network for field latents [Mitchel2024]. No torch.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Quantity that a denoising network predicts from Z_t = sqrt(alpha) Z + sqrt(1 - alpha) epsilon.
enum class DiffusionTarget
{
  Noise,   ///< the paper's: epsilon
  Data,    ///< Z
  Velocity ///< sqrt(alpha) epsilon - sqrt(1 - alpha) Z
};

/// Sizes of the network and its noise schedule. Defaults are the paper's (section 9.2) where it names them.
struct LatentDiffusionOptions
{
  std::int64_t LatentDimension = 8;     ///< d, tangent vectors of a latent code, 1 to 256
  std::int64_t Channels = 96;           ///< C, channels on the surface, 1 to 4096
  std::int64_t CoarseChannels = 192;    ///< channels on the coarser level, 1 to 4096
  std::int64_t InputBlocks = 2;         ///< FCResNet blocks before pooling, 1 to 64
  std::int64_t CoarseBlocks = 4;        ///< blocks on the coarser level, 1 to 64
  std::int64_t OutputBlocks = 4;        ///< blocks after unpooling, 1 to 64
  std::int64_t EmbeddingDimension = 64; ///< e, numbers of the embedding, even, 2 to 4096; the paper names no number
  std::int64_t NumberOfLabels = 0;      ///< labels of vertices, 0 (no label guidance) to 65536
  bool Directed = false;                ///< true when a tangent vector at each vertex guides the directions
  std::int64_t TimeSteps = 1000;        ///< T, steps of the forward process, 1 to 100000
  double FirstVariance = 1e-4;          ///< variance that the first step adds, more than 0, below 1
  double LastVariance = 0.02;           ///< variance that the last step adds, FirstVariance to below 1; linear between
  DiffusionTarget Target = DiffusionTarget::Noise; ///< what the network predicts

  /// The sizes of the paper: the defaults.
  static LatentDiffusionOptions Paper();
  /// Sizes that two processor cores train in hours: 32 channels, 48 on the coarser level, 1 + 2 + 2 blocks.
  static LatentDiffusionOptions Small();
};

/// Compares all options.
bool operator==(const LatentDiffusionOptions& a, const LatentDiffusionOptions& b);

/// Checks the options.
/// @throws InvalidInput naming the first option that is out of its range, or the variances when the forward process leaves
/// less than exp(-300) of the variance of the latents.
void CheckOptions(const LatentDiffusionOptions& options);

/// Tangent vectors of a vertex that the first map sees: d of the state, the direction of the ring's centroid
/// (TangentNeighborhoods::Centroids) and, in directed models, the direction of the guidance (0 without).
std::int64_t InputVectors(const LatentDiffusionOptions& options);

/// Text of a target in model files and commands: "noise", "data", "velocity".
std::string NameOf(DiffusionTarget target);

/// Shapes of all tensors, by name. Complex matrices are [2, out, in]: real part, then imaginary part. With C channels,
/// d tangent vectors, e numbers of the embedding:
///
/// - latent_scale [d]: factors of equation 39, larger than 0.
/// - time.0.weight, time.2.weight [e, e], time.0.bias, time.2.bias [e]: the MLP after the sinusoidal embedding, SiLU.
/// - labels.weight [L, e]: added to the embedding of the vertices with a label; only with labels.
/// - input.weight [2, C, d + 1], or d + 2 with directions, output.weight [2, d, C]; input.gains.weight and
///   output.gains.weight [C, e]: the factors of the C channels of either are 1 + gains times the embedding.
/// - input.B, coarse.B, output.B for block B, with a inputs and b outputs:
///   .residual.weight [2, b, a], only when a is not b; .gains.weight [b, e], factors of the results of convolution2;
///   .mlp1.N and .mlp2.N, N = 0, 1, 2: .norm.scale [2, a] and .norm.log_delta [a] of equation 20, .key.weight and
///   .query.weight [2, b, a] of equation 19 (a = b but in the first);
///   .convolution1 and .convolution2: .filter.radius [8], .filter.aligned [2, 8], .filter.bias [8],
///   .filter.hidden.weight [8, 8], .filter.hidden.bias [8], .weight [2, b, 8, b]; the second one also
///   .filter.embedding [8, e], .filter.centroids [2, 8] and, with directions, .filter.directed [2, 8].
///
/// The first coarse block has C inputs, the first output block CoarseChannels + C: unpooled ones, then those of the last
/// input block.
std::map<std::string, std::vector<std::int64_t>> ExpectedLatentDiffusionTensors(const LatentDiffusionOptions& options);

} // namespace surfsynth
