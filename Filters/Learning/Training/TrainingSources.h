// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A dataset made ready for training. Private to the training; no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/SignalDataset.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Inference/FlowMatching/FlowNoiseField.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <memory>
#include <vector>

namespace surfsynth
{

/// A surface in the network's coordinates, prepared for training.
struct TrainingSource
{
  PoissonOperators Operators;
  FeatureMatrix Condition; ///< [V, 3 + E]: positions and encoding
  SignalSamples Samples;   ///< [N, V C] in the network's units
  std::unique_ptr<FlowNoiseField> Noise;
};

/// The surfaces of a dataset in the network's coordinates, and the frame that its model stores.
struct TrainingSources
{
  std::vector<TrainingSource> Sources;
  std::int64_t Components = 0;
  /// The model without its velocity: signal, normalisation, noise with its scale, shape, encoder.
  FlowMatchingModel Frame;
};

/// @param initial the model whose training goes on: its encoder, noise and units take the place of others; or null.
/// @param encoder may be null. @param noise with a Scale of 0 for one that makes noise vary as much as the samples about
/// their mean, and with Smoothing in squared mean edge lengths: both in the mean over all surfaces, which have area 1.
/// @throws InvalidInput when the dataset is not complete, a surface does not meet FlowMatchingSampler::Requirements(),
/// several have different shapes and there is no encoder, the samples do not vary, or they are another signal than that of
/// @p initial; SolverFailure; Cancelled.
TrainingSources PrepareSources(SignalDataset dataset, const FlowMatchingModel* initial, const PoissonNetModel* encoder,
  const FlowNoise& noise, std::uint64_t seed, const Progress& progress);

/// 64-bit hash of the signal's name, surfaces and samples: tells whether a checkpoint belongs to a dataset.
std::uint64_t ContentHash(const SignalDataset& dataset);

} // namespace surfsynth
