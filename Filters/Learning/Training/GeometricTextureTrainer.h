// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of geometric textures. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// The recipe. Defaults are those of "Deep Geometric Texture Synthesis" (Hertz et al. 2020).
struct GeometricTextureTrainingOptions
{
  GeometricTextureOptions Network;        ///< but for Levels: there are as many as in the dataset
  std::string Name = "texture";           ///< of the model, for people; not empty
  std::int64_t IterationsPerLevel = 2000; ///< >= 1
  std::int64_t DiscriminatorSteps = 2;    ///< in an iteration, 1 to 1000
  std::int64_t GeneratorSteps = 3;        ///< in an iteration, after those, 1 to 1000
  double LearningRate = 5e-4;             ///< of Adam with decays 0.5 and 0.99, > 0
  std::int64_t LearningRateInterval =
    500;                             ///< iterations of a level after which the rate is multiplied, each time; >= 1
  double LearningRateFactor = 0.5;   ///< by this, in (0, 1]
  double PenaltyWeight = 0.1;        ///< of the gradient penalty, >= 0
  double ReconstructionWeight = 5.0; ///< of the mean squared distance from the reference, >= 0
  std::uint64_t Seed = 0;
  TrainingDevice Device = TrainingDevice::Auto;
};

/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const GeometricTextureTrainingOptions& options);

/// What an iteration says of itself: means over its steps.
struct GeometricTextureTrainingStep
{
  std::int64_t Iteration = 0; ///< over all levels, 1 for the first
  std::int64_t Level = 0;
  double CriticLoss = 0.0;         ///< of the discriminator: value of generated meshes minus that of the reference
  double GradientPenalty = 0.0;    ///< before it is weighted
  double AdversarialLoss = 0.0;    ///< of the generator: minus the value of generated meshes
  double ReconstructionLoss = 0.0; ///< mean squared distance from the reference, in squared mean edge lengths
  double LearningRate = 0.0;
};

/// Receives each iteration on the calling thread; false stops the training after it, as cancelling does.
using GeometricTextureTrainingObserver = std::function<bool(const GeometricTextureTrainingStep& step)>;

/// Trains a texture from one mesh at several scales (sections 3 and 4): level by level, a generator that displaces the
/// vertices of a mesh against a discriminator that looks at features of triangles, a Wasserstein GAN with gradient penalty.
/// Levels below the one that is trained stay as they are. A level whose channels are those of the level before begins with
/// its weights.
///
/// Everything random is a pure function of (seed, level, iteration, step), so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
class GeometricTextureTrainer
{
public:
  /// @throws InvalidInput when an option is out of range, the dataset is not one of CheckDataset(), a mesh does not meet
  /// GeometricTextureSampler::Requirements(), or CUDA is asked for and there is none.
  GeometricTextureTrainer(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options);
  ~GeometricTextureTrainer();
  GeometricTextureTrainer(GeometricTextureTrainer&&) noexcept;
  GeometricTextureTrainer& operator=(GeometricTextureTrainer&&) noexcept;

  /// One iteration of the level that is trained. @throws SolverFailure when a loss or its gradient is not finite: the
  /// learning rate is too high; InvalidInput after the last iteration of the last level.
  GeometricTextureTrainingStep Step();

  /// Number of iterations done, and of all to be done: those of all levels.
  std::int64_t Iteration() const;
  std::int64_t Iterations() const;
  /// All iterations done, those before a checkpoint included.
  const std::vector<GeometricTextureTrainingStep>& History() const;
  /// "CPU" or "CUDA".
  std::string DeviceName() const;

  /// Weights, the optimisers' moments and the history, as safetensors; replaces the file only when all is written.
  /// @throws InvalidInput when the file cannot be written; what was there before is then still there.
  void SaveCheckpoint(const std::string& path) const;
  /// Goes on from a checkpoint of the same dataset and options, but for Name and Device.
  /// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch naming what differs. Nothing has
  /// changed then.
  void LoadCheckpoint(const std::string& path);

  /// The model as it is now, with its template and the noise that reconstructs the reference. Levels that are not trained
  /// yet have the weights that they begin with.
  GeometricTextureModel Model() const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Trains to the last iteration of the last level, with checkpoints as TrainFlowMatching(), and one after each level.
/// @returns the trainer, with model and history.
/// @throws what GeometricTextureTrainer throws; before any work, InvalidInput as CheckFiles(); Cancelled.
GeometricTextureTrainer TrainGeometricTexture(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options,
  const TrainingFiles& files, const GeometricTextureTrainingObserver& observe = {}, const Progress& progress = {});

/// Writes the rows of @p history: iteration, level, critic_loss, gradient_penalty, adversarial_loss, reconstruction_loss,
/// learning_rate.
/// @throws InvalidInput when the file cannot be written.
void WriteLossTable(const std::string& path, const std::vector<GeometricTextureTrainingStep>& history);

} // namespace surfsynth
