// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of geometric textures. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// Objective of the generators of all levels.
enum class TextureObjective
{
  Adversarial,       ///< a discriminator, as published
  SlicedWasserstein, ///< the sliced Wasserstein distance of edge features, and of features of 3 and of 6 rings
  FlowMatching       ///< the velocity of a flow from noise to the displacements of the reference [Lipman2023]
};

/// The recipe. Defaults are those of "Deep Geometric Texture Synthesis" (Hertz et al. 2020), but for the objective: flow
/// matching makes better textures in less time.
struct GeometricTextureTrainingOptions : ModelTrainingOptions
{
  GeometricTextureOptions Network; ///< but for Levels: there are as many as in the dataset
  std::string Name = "texture";    ///< of the model, for people; not empty
  TextureObjective Objective =
    TextureObjective::FlowMatching; ///< what the generators learn by; the paper's Adversarial
  std::int64_t FlowSteps = 10;      ///< of the flow at each level in a synthesis, 1 to 1000
  /// Of a flow: largest standard deviation of noise on each coordinate of the level before, in its mean edge lengths; >= 0
  double BaseNoiseAmplitude = 0.1;
  /// Of a flow: samples of the level before, near the reference, that take its place as base, 0 to 100; 0: none do
  std::int64_t BaseSamples = 8;
  std::int64_t Projections = 64;          ///< directions of the sliced Wasserstein distance in a step, 1 to 10000
  std::int64_t IterationsPerLevel = 2000; ///< >= 1
  /// Iterations of each level in turn, >= 1, as many as there are levels; empty: IterationsPerLevel of each. Coarse
  /// levels, where features are placed, cost a fraction of the finest one.
  std::vector<std::int64_t> IterationsOfLevels;
  std::int64_t DiscriminatorSteps = 2; ///< in an iteration, 1 to 1000
  std::int64_t GeneratorSteps = 3;     ///< in an iteration, after those, 1 to 1000
  /// Iterations of a level after which the learning rate of Adam, whose decays are 0.5 and 0.99, is multiplied, each
  /// time; >= 0. 0: a quarter of the iterations of the level, at least 1.
  std::int64_t LearningRateInterval = 500;
  double LearningRateFactor = 0.5; ///< by this, in (0, 1]
  double PenaltyWeight = 0.1;      ///< of the gradient penalty, >= 0
  /// Steps of the discriminator in a level from one gradient penalty to the next, which weighs as many times as much
  /// [Karras2020], 1 to 1000; 1: in each step, as published.
  std::int64_t PenaltyInterval = 1;
  double ReconstructionWeight = 5.0; ///< of the mean squared distance from the reference, >= 0
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const GeometricTextureTrainingOptions& options);

/// Returns the iterations of each of @p levels levels.
/// @throws InvalidInput when IterationsOfLevels is neither empty nor of that length.
std::vector<std::int64_t> IterationsOfEachLevel(const GeometricTextureTrainingOptions& options, std::size_t levels);

/// Trains a texture from one mesh at several scales, or several such references: level by level, a generator that
/// displaces the vertices of a mesh. With TextureObjective::Adversarial (sections 3 and 4) it learns against a
/// discriminator that looks at features of triangles, a Wasserstein GAN with gradient penalty. Levels below the one
/// that is trained stay as they are. A level whose channels are those of the level before begins with its weights.
///
/// With TextureObjective::SlicedWasserstein there is no discriminator: the distance of the features of the generated mesh
/// from those of the reference (CompareGeometricTextures(), 1, 3 and 6 rings, in as many random directions as
/// Projections) takes the place of its value. With TextureObjective::FlowMatching, with b the level before of the reference,
/// subdivided, d = reference - b, noise n and a time t uniform in [0, 1], the network gets b + (1 - t) n + t d and is to give
/// d - n. It is not told t, which the noise shows. In a synthesis b comes from the level below, which is never quite the
/// reference. Therefore b is one of BaseSamples samples of the level below in the training: the displacements of the
/// reference, twice mixed with noise as at half of the time of the flow, from where it goes on in five steps [Meng2022], so that
/// features are where the reference has them, and shaped as that level shapes them. And b has noise of a standard deviation
/// uniform in [0, BaseNoiseAmplitude] (conditioning augmentation [Ho2022]). A flow does not reconstruct the reference.
///
/// Of several references, each a surface with the same texture, each iteration draws one: surfaces of other curvature,
/// for textures that are to grow on such. Their triangles should be of the same size beside the features of the
/// texture. The model has the template of the first one, and statistics of channels over all.
///
/// Everything random is a pure function of (seed, level, iteration or sample, step), so that a training that was interrupted and
/// resumed gives the weights of one that was not, bit for bit with the same number of threads on the same machine.
class GeometricTextureTrainer : public ModelTrainer
{
public:
  /// @throws InvalidInput when an option is out of range, the dataset is not one of CheckDataset(), a mesh does not
  /// meet GeometricTextureSampler::Requirements(), or CUDA is asked for and there is none.
  GeometricTextureTrainer(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options);
  /// Trains from several references. @throws InvalidInput as above, and when there is none or one has another number of
  /// levels than the first.
  GeometricTextureTrainer(
    const std::vector<MultiscaleDataset>& references, const GeometricTextureTrainingOptions& options);
  ~GeometricTextureTrainer() override;
  GeometricTextureTrainer(GeometricTextureTrainer&&) noexcept;
  GeometricTextureTrainer& operator=(GeometricTextureTrainer&&) noexcept;

  /// One iteration of the level that is trained. @throws SolverFailure when a loss or its gradient is not finite: the
  /// learning rate is too high; InvalidInput after the last iteration of the last level.
  void Step() override;
  /// Number of the iterations of all levels.
  std::int64_t Iterations() const override;
  /// Columns iteration (over all levels), level, and means over the steps of the iteration: critic_loss (of the
  /// discriminator: value of generated meshes minus that of the reference; 0 without one), gradient_penalty (before it is
  /// weighted; 0 in iterations without one), adversarial_loss (of the generator: minus the value of generated meshes, or
  /// the sliced Wasserstein distance; 0 of a flow), reconstruction_loss (mean squared distance from the reference, of a
  /// flow of the velocity from its target, in squared mean edge lengths; monitored); and learning_rate.
  const LossHistory& History() const override;
  /// True after the last iteration of each level.
  bool IsAtEndOfStage() const override;
  std::string DeviceName() const override;
  void SaveModel(const std::string& path) const override;
  /// Without the statistics of the channels on the reference, which take seconds.
  void SaveUnfinishedModel(const std::string& path) const override;

  /// The model as it is now, with its template and the noise that reconstructs the reference. Levels that are not
  /// trained yet have the weights that they begin with.
  GeometricTextureModel Model() const;

private:
  GeometricTextureModel ModelWithoutStatistics() const;
  /// All but Name and Device.
  std::map<std::string, std::string> Recipe() const override;
  TrainingCheckpoint Checkpoint() const override;
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint) override;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Time of an iteration of each level, in the unit of one multiplication for each triangle: that of both networks, and
/// an overhead. For TrainingClock.
std::vector<double> CostsOfLevels(const MultiscaleDataset& dataset, const GeometricTextureOptions& network);
/// The same for several references: means over them.
std::vector<double> CostsOfLevels(
  const std::vector<MultiscaleDataset>& references, const GeometricTextureOptions& network);

/// Trains to the last iteration of the last level as TrainAndSave(); the files are checked before the trainer is made.
/// @returns the trainer, with model and history.
/// @throws the errors of GeometricTextureTrainer and TrainAndSave().
GeometricTextureTrainer TrainGeometricTexture(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe = {}, const Progress& progress = {});
/// The same from several references.
GeometricTextureTrainer TrainGeometricTexture(const std::vector<MultiscaleDataset>& references,
  const GeometricTextureTrainingOptions& options, const TrainingFiles& files, const TrainingObserver& observe = {},
  const Progress& progress = {});

} // namespace surfsynth
