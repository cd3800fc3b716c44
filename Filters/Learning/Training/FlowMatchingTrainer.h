// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of flow matching models. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/SignalDataset.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/SourceMemory.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace surfsynth
{

/// Noise::Smoothing of a training that chooses it: DefaultSmoothing().
constexpr double ChosenSmoothing = -1.0;

/// Smoothing of the noise that serves a signal, in squared mean edge lengths: 0 for positions, 1 for others. Smoothed noise has
/// nothing on finer triangulations that the training does not know, where a network without an integration at its end can fail.
/// But positions keep their short waves to the end of the flow, and these tell a sample from the weak noise in them before the
/// network can see it: with smoothed noise, models of shapes vary less than the data.
double DefaultSmoothing(bool positions);

/// Prediction that serves a signal best: FlowPrediction::Data of positions, whose relief is then that of the source, and
/// Preconditioned of others, which are sharper so.
FlowPrediction DefaultPrediction(bool positions);

/// The recipe; what the paper has (appendix B.1) is given beside other defaults.
struct FlowMatchingTrainingOptions : TrainingOptions
{
  /// With a Scale of 0 for such that noise varies as much as the samples do about their mean (about the surface, where there
  /// is one sample on it), and Smoothing, of each kind of noise, in squared mean edge lengths, or ChosenSmoothing. Both are
  /// means over all surfaces, scaled to area 1. The paper's smoothing is 0.
  FlowNoise Noise = { NoiseModel::Matern, 100.0, 256, 0.0, ChosenSmoothing };
  /// Predicts the encoding of section 5.1.2 from positions; for datasets of many surfaces. See EncodingTrainer.h.
  std::optional<PoissonNetModel> Encoder;
  /// Trains on surfaces of different shape without an encoder, for comparison: the network is told positions alone, which
  /// mean something else on each shape. Such datasets are refused otherwise. Not with Encoder.
  bool WithoutEncoder = false;
  /// Quantity that the network predicts, none for DefaultPrediction(); the paper's Velocity. Data are learnt with the
  /// loss of the velocity times min(1, 30 (1 - t)^2), which else grows without bound as t nears 1. Unless velocities are
  /// predicted, both terms of the loss are in units of the mean squares of the data and of their gradients, so that
  /// weights of 1 serve each signal.
  std::optional<FlowPrediction> Prediction;
  /// The model whose weights the training begins with, to go on with other data or another triangulation. Noise,
  /// prediction and the sizes of the network are then those of this model, and so is the encoder unless Encoder replaces
  /// it by another one with as many channels, of the same eigenfunctions.
  std::optional<FlowMatchingModel> InitialModel;
  std::int64_t BatchSize = 32;      ///< samples in an iteration, >= 1; the paper's 32
  std::int64_t SourcesPerBatch = 1; ///< surfaces that an iteration's samples come from, >= 1; divides BatchSize
  /// MiB, >= 0: limit of the memory, on processor and device together, that operators and factorisations of the sources
  /// take, about 1.6 KiB a vertex on the processor, and 4 bytes for each pair of vertices on CUDA. Where not all fit, those
  /// in use last are kept, and others are built again when an iteration draws their source: at most once for the BatchSize /
  /// SourcesPerBatch samples that it takes from it, so that a build is little beside them. The sources of a batch, their
  /// order and all bits of the result are the same with every limit. A single source that is larger is kept while it is in
  /// use, and while the sources are prepared there is one more. Surfaces, samples and encodings stay in memory.
  double SourceMemory = 8192.0;
  double VertexWeight = 1.0;   ///< of the loss in velocities, >= 0
  double JacobianWeight = 1.0; ///< of the loss in their gradients, >= 0
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const FlowMatchingTrainingOptions& options);

/// Trains a velocity field: rectified flow, f_t = (1 - t) f_0 + t f_1 with f_0 noise, f_1 a sample and t uniform in
/// [0, 1), and the loss of equation 12 (section 4).
///
/// Everything random is a pure function of the seed and the iteration, so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
/// On the processor each thread computes samples of its own, where a surface's part of the batch has one for each thread.
class FlowMatchingTrainer : public ModelTrainer
{
public:
  /// Checks and normalises the surfaces, computes their operators and the scale of the noise, and makes the network.
  /// @throws InvalidInput when an option is out of range, the dataset is not complete, a surface does not meet
  /// FlowMatchingSampler::Requirements(), or CUDA is asked for and there is none; SolverFailure;
  /// Cancelled.
  FlowMatchingTrainer(SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress = {});
  ~FlowMatchingTrainer() override;
  FlowMatchingTrainer(FlowMatchingTrainer&&) noexcept;
  FlowMatchingTrainer& operator=(FlowMatchingTrainer&&) noexcept;

  void Step() override;
  std::int64_t Iterations() const override;
  /// Columns iteration, loss, vertex_loss, jacobian_loss (of the velocity, in the units that FlowMatchingTrainingOptions::
  /// Prediction says), gradient_norm (before it is clipped), learning_rate, and loss_1 to loss_8: loss_k is the mean of the
  /// loss (VertexWeight times that in velocities plus JacobianWeight times that in their gradients) over the samples of the
  /// iteration at times t in [(k - 1) / 8, k / 8). It keeps its number in iterations without such a sample, and is 0 before the
  /// first one.
  const LossHistory& History() const override;
  const FlowMatchingTrainingOptions& Options() const;
  /// Memory of the operators of the sources, and builds of them since the trainer was made.
  const SourceMemoryUse& SourceMemory() const;
  std::string DeviceName() const override;
  void SaveModel(const std::string& path) const override;

  /// The model as it is now, in the file's form.
  FlowMatchingModel Model() const;

private:
  /// All but Iterations, Schedule, Milestones, SourceMemory and Device.
  std::map<std::string, std::string> Recipe() const override;
  TrainingCheckpoint Checkpoint() const override;
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint) override;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Trains to the last iteration as TrainAndSave(); the files are checked before the trainer is made.
/// @returns the trainer, with model and history.
/// @throws the errors of FlowMatchingTrainer and TrainAndSave().
FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe = {}, const Progress& progress = {});

} // namespace surfsynth
