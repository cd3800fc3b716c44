// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of flow matching models. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/SignalDataset.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace surfsynth
{

/// The recipe. Defaults are the paper's (appendix B.1) but for the network's size, the batch and the iterations.
struct FlowMatchingTrainingOptions : TrainingOptions
{
  std::int64_t Width = 64;        ///< hidden channels; the paper's 128
  std::int64_t Blocks = 4;        ///< the paper's 5
  std::int64_t ComplexLayers = 3; ///< of the maps between gradients
  /// See PoissonNetOptions::InnerProducts. They grow with the gradients of the noise, and jump where the surface has creases,
  /// so that with them a model serves other triangulations less well.
  bool InnerProducts = false;
  /// With a Scale of 0 for such that noise varies as much as the samples do about their mean (about the surface, where there
  /// is one sample on it), and Smoothing in squared mean edge lengths of the first surface: at 1 the noise has nothing on
  /// finer triangulations that this one does not resolve. The paper's is 0.
  FlowNoise Noise = { NoiseModel::Matern, 100.0, 256, 0.0, 1.0 };
  /// Predicts the encoding of section 5.1.2 from positions; for datasets of many surfaces. See EncodingTrainer.h.
  std::optional<PoissonNetModel> Encoder;
  std::int64_t BatchSize = 8;       ///< samples in an iteration, >= 1; the paper's 32
  std::int64_t SourcesPerBatch = 1; ///< surfaces that an iteration's samples come from, >= 1; divides BatchSize
  double VertexWeight = 1.0;        ///< of the loss in velocities, >= 0
  double JacobianWeight = 1.0;      ///< of the loss in their gradients, >= 0
};

/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const FlowMatchingTrainingOptions& options);

/// Trains a velocity field: rectified flow, f_t = (1 - t) f_0 + t f_1 with f_0 noise, f_1 a sample and t uniform in
/// [0, 1), and the loss of equation 12 (section 4).
///
/// Everything random is a pure function of the seed and the iteration, so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
class FlowMatchingTrainer
{
public:
  /// Checks and normalises the surfaces, computes their operators and the scale of the noise, and makes the network.
  /// @throws InvalidInput when an option is out of range, the dataset is not complete, a surface does not meet
  /// FlowMatchingSampler::Requirements(), or CUDA is asked for and there is none; SolverFailure;
  /// Cancelled.
  FlowMatchingTrainer(SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress = {});
  ~FlowMatchingTrainer();
  FlowMatchingTrainer(FlowMatchingTrainer&&) noexcept;
  FlowMatchingTrainer& operator=(FlowMatchingTrainer&&) noexcept;

  /// One iteration. @throws SolverFailure when the loss is not finite: the learning rate is too high.
  TrainingStep Step();

  /// Number of iterations done.
  std::int64_t Iteration() const;
  /// All iterations done, those before a checkpoint included.
  const std::vector<TrainingStep>& History() const;
  const FlowMatchingTrainingOptions& Options() const;
  /// "CPU" or "CUDA".
  std::string DeviceName() const;

  /// Weights, the optimiser's moments and the history, as safetensors; replaces the file only when all is written.
  /// @throws InvalidInput when the file cannot be written; what was there before is then still there.
  void SaveCheckpoint(const std::string& path) const;
  /// Goes on from a checkpoint of the same dataset and options, but for Iterations, Milestones and Device.
  /// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch naming what differs.
  void LoadCheckpoint(const std::string& path);

  /// The model as it is now, in the file's form.
  FlowMatchingModel Model() const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Trains to the last iteration, with checkpoints. An interrupted training loses what came after its last checkpoint; on
/// cancellation (by @p observe or @p progress) a checkpoint is written first.
/// A checkpoint of the last iteration is enough to write the other files again.
/// @returns the trainer, with model and history.
/// @throws what FlowMatchingTrainer throws; before any work, InvalidInput when a file has no folder to lie in, is a folder
/// or has the name of another one, or CheckpointInterval is below 1; ModelMismatch when the checkpoint has more iterations
/// than are asked for; Cancelled.
FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe = {}, const Progress& progress = {});

} // namespace surfsynth
