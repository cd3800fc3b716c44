// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The state of a training of textures: what its steps change, and its checkpoints hold. Private to the training.
#pragma once

#include "Learning/Models/TextureNetworks.h"
#include "Learning/Training/TextureLevels.h"
#include "Learning/Training/TextureTrainer.h"
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

class TextureTrainer::Internals
{
public:
  Internals(const MultiscaleDataset& dataset, const TextureTrainingOptions& options);

  TextureTrainingStep Step();
  std::int64_t Done() const { return static_cast<std::int64_t>(this->History.size()); }
  std::int64_t Iterations() const { return this->Options.Network.Levels * this->Options.IterationsPerLevel; }
  std::map<std::string, std::string> Recipe() const;
  TrainingCheckpoint Checkpoint();
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint);

  TextureTrainingOptions Options;
  std::uint64_t DatasetHash;
  torch::Device Where;
  TextureLevels Levels;
  SinglePoints ReconstructionNoise; ///< [V of level 0, 3]
  TextureNetwork Generator;
  TextureNetwork Discriminator;
  std::vector<TextureTrainingStep> History;

private:
  std::int64_t LevelOf(std::int64_t iteration) const { return iteration / this->Options.IterationsPerLevel; }
  double LearningRateAt(std::int64_t iteration) const;
  bool SameChannelsAsBelow(std::int64_t level) const;
  void BeginLevel(std::int64_t level);
  torch::Tensor Noise(std::int64_t slot, std::int64_t level) const;
  torch::Tensor Refined(std::size_t level, const torch::Tensor& positions, const torch::Tensor& noise);
  torch::Tensor CoarseSurface(std::int64_t slot);
  void TakeStep(torch::optim::Adam& optimiser, const torch::nn::Module& network, double loss) const;
  void DiscriminatorStep(std::int64_t slot, TextureTrainingStep& step);
  void GeneratorStep(std::int64_t slot, TextureTrainingStep& step);

  TextureLevelData& Data() { return this->Levels.Data[static_cast<std::size_t>(*this->Current)]; }
  TextureLevelNetworkImpl& LevelGenerator() { return this->Generator->Level(static_cast<std::size_t>(*this->Current)); }
  TextureLevelNetworkImpl& Critic() { return this->Discriminator->Level(static_cast<std::size_t>(*this->Current)); }

  std::optional<std::int64_t> Current; ///< the level that what follows is of
  std::unique_ptr<torch::optim::Adam> GeneratorAdam;
  std::unique_ptr<torch::optim::Adam> DiscriminatorAdam;
  torch::Tensor ReconstructionStart; ///< what the frozen levels make of the noise that reconstructs; of levels above 0
};

} // namespace surfsynth
