// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/GeometricTextureTrainerInternals.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/AdamMoments.h"
#include "Learning/Training/NetworkTraining.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* LossesName = "losses";
/// Columns of the history that cannot be computed from the iteration: critic_loss, gradient_penalty, adversarial_loss and
/// reconstruction_loss.
constexpr std::int64_t LossColumns = 4;
constexpr std::size_t FirstLossColumn = 2;

void AddNetwork(const std::string& prefix, GeometricTextureNetworkImpl& network, TrainingCheckpoint& checkpoint)
{
  for (auto& [name, tensor] : GeometricTextureTensorsOf(network))
  {
    checkpoint.Tensors[prefix + name] = tensor;
  }
}

void AddAdamMoments(
  const std::string& prefix, torch::optim::Adam& optimizer, torch::nn::Module& network, TrainingCheckpoint& checkpoint)
{
  for (const auto& parameter : network.named_parameters())
  {
    const AdamMoments moments = GetMoments(optimizer, parameter.value());
    checkpoint.Tensors["adam_mean." + prefix + parameter.key()] = ToModelTensor(moments.Mean);
    checkpoint.Tensors["adam_square." + prefix + parameter.key()] = ToModelTensor(moments.Square);
  }
}

/// @throws ModelMismatch when there is none of at most @p rows rows.
const ModelTensor& LossesOf(const std::string& file, const TrainingCheckpoint& checkpoint, std::int64_t rows)
{
  const auto losses = checkpoint.Tensors.find(LossesName);
  const bool table = losses != checkpoint.Tensors.end() && losses->second.Shape.size() == 2 &&
    losses->second.Shape[1] == LossColumns && losses->second.Shape[0] <= rows;
  if (!table)
  {
    throw ModelMismatch(file + ": \"losses\" is no table of four columns and at most " + std::to_string(rows) +
      " rows; expected a checkpoint of this training.");
  }
  return losses->second;
}

/// A parameter and what it becomes.
struct RestoredParameter
{
  torch::Tensor Parameter;
  torch::Tensor Value;
  AdamMoments Moments; ///< undefined but for those of the current level
};

/// @param current beginning of the names of the parameters whose moments the checkpoint holds; empty for none.
/// @throws ModelMismatch
std::vector<RestoredParameter> RestoreNetwork(const std::string& file, const TrainingCheckpoint& checkpoint,
  const std::string& prefix, torch::nn::Module& network, const std::string& current)
{
  std::vector<RestoredParameter> restored;
  for (const auto& parameter : network.named_parameters())
  {
    const std::string& name = parameter.key();
    const auto read = [&](
                        const std::string& tensor) { return ReadTensor(file, checkpoint, tensor, parameter.value()); };
    RestoredParameter part{ parameter.value(), read(prefix + name), {} };
    if (!current.empty() && name.compare(0, current.size(), current) == 0)
    {
      part.Moments = ReadMoments(file, checkpoint, prefix + name.substr(current.size()), parameter.value());
    }
    restored.push_back(std::move(part));
  }
  return restored;
}

/// One number when all levels have as many, else one for each.
std::string DescribeIterations(const std::vector<std::int64_t>& iterations)
{
  std::string text = std::to_string(iterations.front());
  if (std::adjacent_find(iterations.begin(), iterations.end(), std::not_equal_to<>()) == iterations.end())
  {
    return text;
  }
  for (std::size_t level = 1; level < iterations.size(); ++level)
  {
    text += "," + std::to_string(iterations[level]);
  }
  return text;
}

void SetParameters(const std::vector<RestoredParameter>& restored)
{
  for (const RestoredParameter& part : restored)
  {
    torch::Tensor parameter = part.Parameter;
    parameter.copy_(part.Value);
  }
}

void SetAllMoments(const std::vector<RestoredParameter>& restored, torch::optim::Adam& optimizer, std::int64_t steps)
{
  for (const RestoredParameter& part : restored)
  {
    if (part.Moments.Mean.defined())
    {
      SetMoments(optimizer, part.Parameter, part.Moments, steps);
    }
  }
}
} // namespace

std::map<std::string, std::string> GeometricTextureTrainer::Internals::Recipe() const
{
  const GeometricTextureTrainingOptions& o = this->Options;
  std::map<std::string, std::string> recipe = { { "training", "geometric_texture" },
    { "levels", std::to_string(o.Network.Levels) }, { "layers", std::to_string(o.Network.Layers) },
    { "start_channels", std::to_string(o.Network.StartChannels) },
    { "least_channels", std::to_string(o.Network.MinimumChannels) },
    { "most_channels", std::to_string(o.Network.MaximumChannels) },
    { "noise_amplitude", FormatExact(o.Network.NoiseAmplitude) },
    { "iterations_per_level", DescribeIterations(IterationsOfEachLevel(o, this->LevelEnds.size())) },
    { "discriminator_steps", std::to_string(o.DiscriminatorSteps) },
    { "generator_steps", std::to_string(o.GeneratorSteps) }, { "learning_rate", FormatExact(o.LearningRate) },
    { "learning_rate_interval", std::to_string(o.LearningRateInterval) },
    { "learning_rate_factor", FormatExact(o.LearningRateFactor) }, { "penalty_weight", FormatExact(o.PenaltyWeight) },
    { "reconstruction_weight", FormatExact(o.ReconstructionWeight) }, { "seed", std::to_string(o.Seed) },
    { "dataset", std::to_string(this->DatasetHash) } };
  if (o.PenaltyInterval != 1) // checkpoints of trainings that could have no other have no entry
  {
    recipe["penalty_interval"] = std::to_string(o.PenaltyInterval);
  }
  if (o.Objective == TextureObjective::SlicedWasserstein)
  {
    recipe["objective"] = "sliced_wasserstein";
    recipe["projections"] = std::to_string(o.Projections);
  }
  if (o.Objective == TextureObjective::FlowMatching)
  {
    recipe["objective"] = "flow_matching"; // steps matter to a synthesis alone
    recipe["base_noise_amplitude"] = FormatExact(o.BaseNoiseAmplitude);
    if (o.BaseSamples != 0) // checkpoints of trainings that could have none have no entry
    {
      recipe["base_samples"] = std::to_string(o.BaseSamples);
    }
  }
  return recipe;
}

TrainingCheckpoint GeometricTextureTrainer::Internals::Checkpoint()
{
  TrainingCheckpoint checkpoint;
  checkpoint.Recipe = this->Recipe();
  AddNetwork("generator.", *this->Generator, checkpoint);
  AddNetwork("discriminator.", *this->Discriminator, checkpoint);
  if (!this->IsBetweenLevels())
  {
    AddAdamMoments("generator.", *this->GeneratorAdam, this->LevelGenerator(), checkpoint);
    if (this->HasDiscriminator())
    {
      AddAdamMoments("discriminator.", *this->DiscriminatorAdam, this->Critic(), checkpoint);
    }
  }
  ModelTensor& losses = checkpoint.Tensors[LossesName];
  losses.Shape = { this->Done(), LossColumns };
  for (std::size_t k = 0; k < this->History.Size(); ++k)
  {
    for (std::size_t column = 0; column < LossColumns; ++column)
    {
      losses.Values.push_back(static_cast<float>(this->History.Row(k)[FirstLossColumn + column]));
    }
  }
  return checkpoint;
}

void GeometricTextureTrainer::Internals::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  const torch::NoGradGuard noGradients;
  // All that can fail comes first, so that a training is not left half restored.
  const ModelTensor& losses = LossesOf(file, checkpoint, this->Iterations());
  const std::int64_t done = losses.Shape[0];
  const std::int64_t level = this->LevelOf(done);
  const std::int64_t inLevel = this->InLevel(done);
  const std::string current = inLevel > 0 ? "levels." + std::to_string(level) + "." : "";
  const auto generator = RestoreNetwork(file, checkpoint, "generator.", *this->Generator, current);
  const auto discriminator = RestoreNetwork(
    file, checkpoint, "discriminator.", *this->Discriminator, this->HasDiscriminator() ? current : std::string());

  this->History = GeometricTextureLossHistory();
  const float* loss = losses.Values.data();
  for (std::int64_t k = 0; k < done; ++k, loss += LossColumns)
  {
    this->AppendLosses(k, { loss[0], loss[1], loss[2], loss[3] });
  }
  SetParameters(generator);
  SetParameters(discriminator);
  this->Current.reset();
  if (inLevel > 0)
  {
    this->BeginLevel(level);
    SetAllMoments(generator, *this->GeneratorAdam, inLevel * this->Options.GeneratorSteps);
    SetAllMoments(discriminator, *this->DiscriminatorAdam, inLevel * this->Options.DiscriminatorSteps);
  }
}

} // namespace surfsynth
