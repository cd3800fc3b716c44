// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The state of a training of textures. Private to the training.
#pragma once

#include "Core/Random/CounterNormals.h"
#include "Learning/Networks/GeometricTextureNetworks.h"
#include "Learning/Training/GeometricTextureLevels.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <torch/torch.h>

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace surfsynth
{

/// The losses of one iteration: means over its steps.
struct GeometricTextureLosses
{
  double Critic = 0.0;
  double Penalty = 0.0;
  double Adversarial = 0.0;
  double Reconstruction = 0.0;
};

/// The empty losses; see GeometricTextureTrainer::History().
LossHistory GeometricTextureLossHistory();

/// Standard normals times @p amplitude, [vertices, 3] in float32; coordinates are components from that of @p key on.
SinglePoints NormalPoints(NormalKey key, std::int64_t vertices, double amplitude);

/// The same as a tensor.
torch::Tensor NoiseTensor(const SinglePoints& points, const torch::Device& device);

class GeometricTextureTrainer::Internals
{
public:
  Internals(const std::vector<MultiscaleDataset>& references, const GeometricTextureTrainingOptions& options);

  void Step();
  std::int64_t Done() const { return static_cast<std::int64_t>(this->History.Size()); }
  std::int64_t Iterations() const { return this->LevelEnds.back(); }
  /// True after the last iteration of each level, and before the first one of all.
  bool IsBetweenLevels() const { return this->InLevel(this->Done()) == 0; }
  bool HasDiscriminator() const { return this->Options.Objective == TextureObjective::Adversarial; }
  std::map<std::string, std::string> Recipe() const;
  TrainingCheckpoint Checkpoint();
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint);

  GeometricTextureTrainingOptions Options;
  std::uint64_t DatasetHash;
  torch::Device Where;
  std::vector<GeometricTextureReference> References;
  GeometricTextureNetwork Generator;
  GeometricTextureNetwork Discriminator;
  LossHistory History = GeometricTextureLossHistory();
  std::vector<std::int64_t> LevelEnds; ///< iterations up to the end of each level

private:
  /// The level of an iteration; the number of levels after the last one.
  std::int64_t LevelOf(std::int64_t iteration) const;
  /// Number of iterations of its level before this one; 0 after the last one of all.
  std::int64_t InLevel(std::int64_t iteration) const;
  /// Seed, stream and sample of random numbers of this iteration.
  NormalKey KeyOfIteration() const;
  /// Seed and stream of random numbers of this level.
  NormalKey KeyOfLevel() const;
  double LearningRateAt(std::int64_t iteration) const;
  void AppendLosses(std::int64_t iteration, const GeometricTextureLosses& losses);
  bool SameChannelsAsBelow(std::int64_t level) const;
  void BeginLevel(std::int64_t level);
  void DrawReference();
  torch::Tensor Noise(std::int64_t slot, std::int64_t level);
  torch::Tensor Noise(std::int64_t slot, std::int64_t level, double amplitude);
  torch::Tensor Refined(std::size_t level, const torch::Tensor& positions, const torch::Tensor& noise);
  torch::Tensor CoarseSurface(std::int64_t slot);
  void TakeStep(torch::optim::Adam& optimizer, const torch::nn::Module& network, double loss) const;
  bool HasPenalty(std::int64_t slot) const;
  torch::Tensor Directions(std::int64_t slot, std::int64_t channels) const;
  torch::Tensor SomeRows(std::int64_t slot, std::int64_t point, std::int64_t count) const;
  torch::Tensor SlicedDistance(std::int64_t slot, const torch::Tensor& positions);
  torch::Tensor AdversarialLoss(std::int64_t slot, const torch::Tensor& positions);
  void DiscriminatorStep(std::int64_t slot, GeometricTextureLosses& losses);
  void GeneratorStep(std::int64_t slot, GeometricTextureLosses& losses);
  torch::Tensor NearReference(std::int64_t sample);
  void SampleBases();
  torch::Tensor FlowBase(std::int64_t slot);
  void FlowStep(std::int64_t slot, GeometricTextureLosses& losses);

  GeometricTextureReference& Reference() { return this->References[this->Drawn]; }
  GeometricTextureLevelData& Data() { return this->Reference().Levels.Data[static_cast<std::size_t>(*this->Current)]; }
  GeometricTextureLevelNetworkImpl& LevelGenerator()
  {
    return this->Generator->Level(static_cast<std::size_t>(*this->Current));
  }
  GeometricTextureLevelNetworkImpl& Critic()
  {
    return this->Discriminator->Level(static_cast<std::size_t>(*this->Current));
  }

  std::optional<std::int64_t> Current; ///< the level that the members below are of
  std::unique_ptr<torch::optim::Adam> GeneratorAdam;
  std::unique_ptr<torch::optim::Adam> DiscriminatorAdam;
  std::size_t Drawn = 0; ///< reference of this iteration
};

} // namespace surfsynth
