// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Floating-point operations of field latents, for measurements. Private to the library.
#pragma once

#include "Inference/FieldLatents/FieldLatentOptions.h"

#include <cstdint>

namespace surfsynth
{

/// Operations of the equations of the encoder at one vertex, as they stand: two for each factor of a matrix product, a
/// complex product four real ones. Sums, norms and activations are not counted.
inline double EncoderOperations(const FieldLatentOptions& options, std::int64_t samples)
{
  const auto channels = static_cast<double>(options.Channels);
  const auto tokens = static_cast<double>(samples + 1);
  const double complexMap = 8.0 * channels * channels;
  const double lifting = static_cast<double>(samples) * (2.0 * 12.0 * channels + 2.0 * 2.0 * channels * channels);
  const double attention = 2.0 * 2.0 * tokens * tokens * 2.0 * channels;
  const double layers = static_cast<double>(options.EncoderLayers) * (8.0 * tokens * complexMap + attention);
  const double mean = 2.0 * complexMap + 8.0 * channels * static_cast<double>(options.LatentDimension);
  const double deviation = complexMap + 4.0 * channels * channels +
    2.0 * channels * static_cast<double>(options.LatentDimension);
  return lifting + layers + mean + deviation;
}

/// Operations of one evaluation of the neural field, without the share of the outer products in the first layer, which
/// belongs to the vertex.
inline double NeuralFieldOperations(const FieldLatentOptions& options)
{
  const auto width = static_cast<double>(options.DecoderWidth);
  const auto inputs = static_cast<double>(options.DecoderInputs() - options.NumberOfProducts());
  return 2.0 * width * (inputs + static_cast<double>(options.DecoderLayers - 1) * width + 3.0);
}

/// Operations of the decoder for one texel.
inline double DecoderOperations(const FieldLatentOptions& options)
{
  return (options.Coordinates == FieldLatentCoordinates::Logarithmic ? 3.0 : 1.0) * NeuralFieldOperations(options);
}

} // namespace surfsynth
