// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of the diffusion of field latents. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/LatentDataset.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace surfsynth
{

/// Recipe of [Mitchel2024], section 9.2, but for the sizes, the batch and the iterations, which take eight large GPU two
/// days there.
struct LatentDiffusionTrainingOptions : ModelTrainingOptions
{
  LatentDiffusionTrainingOptions() { this->LearningRate = 1e-3; }

  /// Sizes, schedule and target; the paper's are LatentDiffusionOptions::Paper(). LatentDimension, NumberOfLabels and
  /// Directed are not read: they are those of the dataset.
  LatentDiffusionOptions Network = LatentDiffusionOptions::Small();
  std::int64_t Iterations = 20000; ///< >= 1; the paper's 300,000
  /// Surfaces in an iteration, each with its own time and noise, >= 1; the paper's 16. They are evaluated one after the
  /// other: memory does not grow with their number.
  std::int64_t BatchSize = 4;
  /// Adam is the paper's. Muon moves the complex matrices inside the network and leaves the rest to Adam.
  TrainingOptimizer Optimizer = TrainingOptimizer::Adam;
  /// Learning rate at the end, > 0: it falls from LearningRate along half a cosine. With Muon it rises linearly over the
  /// first hundredth of all iterations.
  double FinalLearningRate = 1e-5;
  double GradientClip = 1.0; ///< norm of all gradients together at most; 0: no limit, as in the paper
  /// The model holds an average of the weights: average = a average + (1 - a) weights, with a = min(WeightAveraging,
  /// (1 + n) / (10 + n)) in iteration n. In [0, 1); 0: the weights themselves, as in the paper. The gradient of few
  /// surfaces, each at one time, is mostly noise, which an average over about 1 / (1 - a) iterations takes out [Ho2020];
  /// with 1000 of 20000 it follows the cosine of the learning rate closely, so that the end loses nothing, and models
  /// written along the way, or after a time budget, gain most.
  double WeightAveraging = 0.999;
  /// Limit gamma of the weights of the loss: the squared error of the data that the prediction means has the weight
  /// min(s, gamma) with the signal-to-noise ratio s = alpha / (1 - alpha) [Hang2023], whatever the target. 0: the squared
  /// error of the target itself, equation 10 for the noise. >= 0; [Hang2023] takes 5.
  double SnrLimit = 0.0;
  /// Probability that a surface of an iteration is seen without labels and directions, 0 to 1: the model then also serves
  /// samples without. Without effect for datasets with neither.
  double ConditionDropout = 0.1;
  /// True to draw the latents of each iteration from their Gaussians (section 5), false for their means.
  bool SampleLatents = true;
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const LatentDiffusionTrainingOptions& options);

/// Trains a denoising network on the field latents of a texture on several triangulations of its surface. Each iteration
/// takes BatchSize surfaces at random. The latents Z of one, scaled by equation 39 (with the mean length over all
/// surfaces), become Z_t = sqrt(alpha_t) Z + sqrt(1 - alpha_t) epsilon, with t uniform in 1 to T; the times of a batch
/// are evenly spread around the circle of a random one. The loss is the mean square of the error of the target (equation
/// 10 over the number of components).
///
/// Everything random is a pure function of the seed and the iteration, so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
class LatentDiffusionTrainer : public ModelTrainer
{
public:
  /// Number of the columns of losses by time.
  static constexpr int NumberOfTimeBins = 8;

  /// Checks the dataset, builds the levels of its surfaces and makes the network.
  /// @throws InvalidInput when an option is out of range, the dataset is not complete, a surface is not manifold, or CUDA
  /// is asked for and there is none.
  LatentDiffusionTrainer(LatentDataset dataset, const LatentDiffusionTrainingOptions& options);
  ~LatentDiffusionTrainer() override;
  LatentDiffusionTrainer(LatentDiffusionTrainer&&) noexcept;
  LatentDiffusionTrainer& operator=(LatentDiffusionTrainer&&) noexcept;

  void Step() override;
  std::int64_t Iterations() const override;
  /// Columns iteration, loss, gradient_norm (before it is clipped), learning_rate, and noise_loss_1 to noise_loss_8. The
  /// latter tell targets and weights apart: noise_loss_k is the mean square of the error of the noise that the prediction
  /// means (equation 10 over the number of components) at times in (T (k - 1) / 8, T k / 8]. It keeps its number in
  /// iterations without such a time, and is 0 before the first one.
  const LossHistory& History() const override;
  /// Recipe, with the sizes that the dataset sets.
  const LatentDiffusionTrainingOptions& Options() const;
  std::string DeviceName() const override;
  void SaveModel(const std::string& path) const override;

  /// The model as it is now.
  LatentDiffusionModel Model() const;

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
/// @throws the errors of LatentDiffusionTrainer and TrainAndSave().
LatentDiffusionTrainer TrainLatentDiffusion(LatentDataset dataset, const LatentDiffusionTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe = {}, const Progress& progress = {});

} // namespace surfsynth
