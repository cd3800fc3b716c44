// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Weights of field latents in the order of the matrix products. Private to the inference.
#pragma once

#include "Inference/FieldLatents/FieldLatentModel.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Affine map of real numbers: x W^T + b.
struct FieldLatentAffine
{
  std::vector<float> Matrix; ///< W^T, [in, out]
  std::vector<float> Bias;   ///< [out]
};

/// Parameters of equation 20.
struct FieldLatentNorm
{
  std::vector<float> Scale; ///< a, [2 C]
  std::vector<float> Delta; ///< delta, [C]
};

/// One VN-transformer layer. Complex maps are real matrices of [re im]. Channels of queries, keys and values, and those
/// that the last map of the attention reads, are ordered by head: real parts of a head, then its imaginary parts.
struct FieldLatentLayer
{
  FieldLatentNorm Norm1;
  FieldLatentNorm Norm2;
  std::vector<float> QueryKeyValue; ///< [2 C, 6 C]
  std::vector<float> Out;           ///< [2 C, 2 C]
  std::vector<float> Neuron1;       ///< [2 C, 4 C], K then Q of equation 19
  std::vector<float> Neuron2;       ///< [2 C, 4 C]
};

/// All weights of the encoder.
struct FieldLatentEncoderWeights
{
  /// Orders the weights of a model that CheckModel() accepts.
  explicit FieldLatentEncoderWeights(const FieldLatentModel& model);

  FieldLatentAffine Lift;
  FieldLatentAffine GatherColors;
  FieldLatentAffine FilterIn;
  FieldLatentAffine FilterOut;
  std::vector<FieldLatentLayer> Layers;
  std::vector<float> MeanNeuron; ///< [2 C, 4 C]
  std::vector<float> MeanOut;    ///< [2 C, 2 d], real and imaginary part of each output in turn
  std::vector<float> Product;    ///< [2 C, 2 C]
  FieldLatentAffine DeviationIn;
  FieldLatentAffine DeviationOut;
};

/// All weights of the decoder.
struct FieldLatentDecoderWeights
{
  /// Orders the weights of a model that CheckModel() accepts.
  explicit FieldLatentDecoderWeights(const FieldLatentModel& model);

  std::vector<float> Coordinates;        ///< [2 d, width], part of the first layer; empty with barycentric coordinates
  std::vector<float> Products;           ///< [d (d + 1), width], part of the first layer
  std::vector<float> Bias;               ///< [width], of the first layer
  std::vector<FieldLatentAffine> Layers; ///< the layers after the first
};

} // namespace surfsynth
