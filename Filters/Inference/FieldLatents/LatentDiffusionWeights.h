// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Weights of a denoising network in the order of the matrix products. Private to the inference.
#pragma once

#include "Inference/FieldLatents/LatentDiffusionModel.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Normalization of equation 20 and vector neuron of equation 19, from a to b channels.
struct FieldNeuron
{
  std::int64_t Inputs = 0;
  std::int64_t Outputs = 0;
  std::vector<float> Scale;  ///< a of equation 20, [2 a]
  std::vector<float> Delta;  ///< delta, [a]
  std::vector<float> Matrix; ///< [2 a, 4 b], K then Q

  /// Matrix that reads the features before their normalization: rows turned and scaled.
  /// @param meanSquares [a], mean of |X|^2 over the vertices
  std::vector<float> Normalized(const std::vector<double>& meanSquares) const;
};

/// Field convolution.
struct FieldConvolutionWeights
{
  std::int64_t Channels = 0;
  std::vector<float> Radius;     ///< [8]
  std::vector<float> Aligned;    ///< [2, 8]
  std::vector<float> Centroids;  ///< [2, 8], zero when the convolution sees no embedding
  std::vector<float> Directed;   ///< [2, 8], zero when the convolution sees no direction
  std::vector<float> Bias;       ///< [8], first layer
  std::vector<float> Embedding;  ///< [8, e]; empty when the convolution sees none
  std::vector<float> Hidden;     ///< [8, 8]
  std::vector<float> HiddenBias; ///< [8]
  std::vector<float> Matrix;     ///< [8 * 2 C, 2 C]: rows by hidden channel, then parts apart
};

/// FCResNet block.
struct FieldBlock
{
  std::vector<float> Residual; ///< [2 a, 2 b]; empty when a is b
  FieldNeuron Mlp1[3];
  FieldConvolutionWeights Convolution1;
  FieldNeuron Mlp2[3];
  FieldConvolutionWeights Convolution2;
  std::vector<float> Gains; ///< [b, e]
};

/// All weights of the network.
struct LatentDiffusionWeights
{
  /// Orders the weights of a model that CheckModel() accepts.
  explicit LatentDiffusionWeights(const LatentDiffusionModel& model);

  std::vector<float> Input;       ///< [2 d, 2 C], parts of the latents in turn
  std::vector<float> Output;      ///< [2 C, 2 d], parts of the result in turn
  std::vector<float> InputGains;  ///< [C, e]
  std::vector<float> OutputGains; ///< [C, e]
  std::vector<FieldBlock> InputBlocks;
  std::vector<FieldBlock> CoarseBlocks;
  std::vector<FieldBlock> OutputBlocks;
  std::vector<float> Time0;     ///< [e, e], by outputs
  std::vector<float> TimeBias0; ///< [e]
  std::vector<float> Time2;     ///< [e, e], by outputs
  std::vector<float> TimeBias2; ///< [e]
  std::vector<float> Labels;    ///< [L, e]
};

} // namespace surfsynth
