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

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace surfsynth
{

/// A surface in the network's coordinates, prepared for training, without what SourceFactors hold.
struct TrainingSource
{
  TriangleMesh Mesh;
  Eigen::VectorXf VertexMass; ///< [V], of PoissonOperators
  FeatureMatrix Condition;    ///< [V, 3 + E]: positions and encoding
  SignalSamples Samples;      ///< [N, V C] in the network's units
  double NoiseSquares = 0.0;  ///< mean square of its noise with scale 1, where it was measured

  /// Number of vertices, V.
  Index NumberOfPoints() const { return this->Mesh.NumberOfPoints(); }
};

/// Operators and factorisations of a surface: most of its memory.
struct SourceFactors
{
  PoissonOperators Operators;
  std::unique_ptr<FlowNoiseField> Noise;
  FlowNoise NoiseOptions; ///< of Noise
};

/// Builds the factors of @p mesh, in the network's coordinates: the same bits each time.
/// @throws SolverFailure, Cancelled.
SourceFactors BuildFactors(const TriangleMesh& mesh, const FlowNoise& noise, const Progress& progress = {});

/// Receives the factors that the preparation of a source needed, and its number.
using FactorConsumer = std::function<void(std::size_t number, const TrainingSource& source, SourceFactors factors)>;

/// The surfaces of a dataset in the network's coordinates, and the frame that its model stores.
struct TrainingSources
{
  std::vector<TrainingSource> Sources;
  std::int64_t Components = 0;
  /// The model without its velocity: signal, normalisation, noise with its scale, shape, encoder.
  FlowMatchingModel Frame;
};

/// @param initial the model whose training goes on: its noise and units take the place of others; or null.
/// @param encoder takes the place of that of @p initial; may be null. @param withoutEncoder allows surfaces of
/// different shape without one
/// @param keep is given the factors of each source, one source after the other. @param noise with a Scale of 0 for one that
/// makes noise vary as much as the samples about their mean, and with Smoothing in squared mean edge lengths: both in the
/// mean over all surfaces, which have area 1.
/// @throws InvalidInput when the dataset is not complete, a surface does not meet FlowMatchingSampler::Requirements(),
/// several have different shapes and there is no encoder, the samples do not vary, or they are another signal than that of
/// @p initial; SolverFailure; Cancelled.
TrainingSources PrepareSources(SignalDataset dataset, const FlowMatchingModel* initial, const PoissonNetModel* encoder,
  bool withoutEncoder, const FlowNoise& noise, std::uint64_t seed, const FactorConsumer& keep,
  const Progress& progress);

/// 64-bit hash of the signal's name, surfaces and samples: tells whether a checkpoint belongs to a dataset.
std::uint64_t ContentHash(const SignalDataset& dataset);

} // namespace surfsynth
