// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of field latents. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/TextureDataset.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace surfsynth
{

/// Recipe of [Mitchel2024], section 9.1, but for the sizes, the batch and the iterations, which take a large GPU hours
/// there.
struct FieldLatentTrainingOptions : ModelTrainingOptions
{
  FieldLatentTrainingOptions() { this->LearningRate = 1e-3; }

  FieldLatentOptions Network = FieldLatentOptions::Small(); ///< sizes; the paper's are FieldLatentOptions::Paper()
  std::int64_t Iterations = 100000;                         ///< >= 1; the paper's 1,500,000
  /// Rings in an iteration, >= 1; the paper's 16. With barycentric coordinates a multiple of 3: the corners of triangles.
  std::int64_t BatchSize = 48;
  /// Learning rate at the end, > 0: it falls from LearningRate along half a cosine.
  double FinalLearningRate = 1e-5;
  double DivergenceWeight = 0.01; ///< lambda of equation 28, >= 0
  double MinimumTexels = 10.0;    ///< least number of pixels of an image for a vertex, > 0; drawn log-uniformly
  double MaximumTexels = 150.0;   ///< largest number of pixels of an image for a vertex; the paper's mean is 26
  /// Power k >= 0: the loss's points have a density proportional to b^k in a ring, where b is the barycentric coordinate
  /// of the ring's vertex, with which its prediction enters the blend. Independent errors e of the three corners blend to
  /// a squared error sum b^2 e^2: with k = 2 the loss measures this. 0: uniform, as equation 26. Of no effect with
  /// barycentric coordinates, whose loss compares the blend itself.
  double TargetPower = 0.0;
  /// Part of the rings whose colors are changed, from 0 to 1: the channels are permuted, and the range of each becomes a
  /// random one, which may be reversed. Photographs have few saturated colors, and textures of models many.
  double ColorAugmentation = 0.0;
  double GradientClip = 1.0; ///< norm of all gradients together at most; 0: no limit, as in the paper
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const FieldLatentTrainingOptions& options);

/// Trains encoder and decoder of field latents on rings of planar meshes that are laid over images, each ring at a random
/// place, angle and scale. The encoder sees FieldLatentOptions::SamplesPerRing random points, the loss (equations 26 to
/// 28) compares as many others with the decoder's prediction from the perspective of the ring's vertex; with barycentric
/// coordinates, points of a triangle with the prediction from its three corners. Latent codes of the loss are samples of
/// the encoder's Gaussians. Colors between pixels are bilinear.
///
/// Everything random is a pure function of the seed and the iteration, so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
class FieldLatentTrainer : public ModelTrainer
{
public:
  /// Checks the dataset and makes the networks.
  /// @throws InvalidInput when an option is out of range, the dataset is not complete, or CUDA is asked for and there is
  /// none.
  FieldLatentTrainer(TextureDataset dataset, const FieldLatentTrainingOptions& options);
  ~FieldLatentTrainer() override;
  FieldLatentTrainer(FieldLatentTrainer&&) noexcept;
  FieldLatentTrainer& operator=(FieldLatentTrainer&&) noexcept;

  void Step() override;
  std::int64_t Iterations() const override;
  /// Columns iteration, loss, reconstruction_loss, divergence_loss (before its weight), gradient_norm (before it is
  /// clipped) and learning_rate.
  const LossHistory& History() const override;
  const FieldLatentTrainingOptions& Options() const;
  std::string DeviceName() const override;
  void SaveModel(const std::string& path) const override;

  /// The model as it is now.
  FieldLatentModel Model() const;

private:
  /// All but Iterations and Device.
  std::map<std::string, std::string> Recipe() const override;
  TrainingCheckpoint Checkpoint() const override;
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint) override;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Trains to the last iteration as TrainAndSave(); the files are checked before the trainer is made.
/// @returns the trainer, with model and history.
/// @throws the errors of FieldLatentTrainer and TrainAndSave().
FieldLatentTrainer TrainFieldLatents(TextureDataset dataset, const FieldLatentTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe = {}, const Progress& progress = {});

} // namespace surfsynth
