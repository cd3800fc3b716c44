// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/GeometricTextureTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/GeometricTextureTrainerInternals.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace surfsynth
{

namespace
{
/// Largest number of levels, and of steps of each kind in an iteration: coordinates of noise are made of both.
constexpr std::uint32_t MaximumNumberOfLevels = 16;

GeometricTextureOptions WithLevels(GeometricTextureOptions network, std::size_t levels)
{
  network.Levels = static_cast<std::int64_t>(levels);
  return network;
}

/// Checks each of @p references beside the others. @throws InvalidInput
void CheckReferences(const std::vector<MultiscaleDataset>& references)
{
  if (references.empty())
  {
    throw InvalidInput("GeometricTextureTrainer: there is no reference; expected at least one.");
  }
  const std::size_t levels = references.front().Levels.size();
  for (std::size_t k = 0; k < references.size(); ++k)
  {
    CheckDataset(references[k]);
    if (references[k].Levels.size() != levels)
    {
      throw InvalidInput("GeometricTextureTrainer: reference " + std::to_string(k) + " has " +
        std::to_string(references[k].Levels.size()) + " levels; expected " + std::to_string(levels) +
        ", as reference 0 has.");
    }
  }
}

/// Of one reference its own hash.
std::uint64_t HashOf(const std::vector<MultiscaleDataset>& references)
{
  std::uint64_t hash = ContentHash(references.front());
  for (std::size_t k = 1; k < references.size(); ++k)
  {
    hash = (hash ^ ContentHash(references[k])) * 0x100000001b3;
  }
  return hash;
}

using Optimizer = std::unique_ptr<torch::optim::Adam>;

Optimizer MakeOptimizer(torch::nn::Module& network, double learningRate)
{
  return std::make_unique<torch::optim::Adam>(
    network.parameters(), torch::optim::AdamOptions(learningRate).betas(std::make_tuple(0.5, 0.99)));
}

void SetLearningRate(torch::optim::Adam& optimizer, double learningRate)
{
  static_cast<torch::optim::AdamOptions&>(optimizer.param_groups()[0].options()).lr(learningRate);
}

void CopyParameters(torch::nn::Module& from, torch::nn::Module& to)
{
  const torch::NoGradGuard noGradients;
  const std::vector<torch::Tensor> source = from.parameters();
  std::vector<torch::Tensor> target = to.parameters();
  for (std::size_t k = 0; k < source.size(); ++k)
  {
    target[k].copy_(source[k]);
  }
}
} // namespace

SinglePoints NormalPoints(NormalKey key, std::int64_t vertices, double amplitude)
{
  SinglePoints points(vertices, 3);
  Eigen::VectorXd coordinates(vertices);
  for (int axis = 0; axis < 3; ++axis, ++key.Component)
  {
    FillNormals(key, 0, vertices, coordinates.data());
    points.col(axis) = (amplitude * coordinates).cast<float>();
  }
  return points;
}

torch::Tensor NoiseTensor(const SinglePoints& points, const torch::Device& device)
{
  return torch::from_blob(const_cast<float*>(points.data()), { points.rows(), 3 }, torch::kFloat32)
    .to(device, torch::kFloat32, false, true);
}

void CheckOptions(const GeometricTextureTrainingOptions& options)
{
  CheckOptions(options.Network);
  if (options.Name.empty())
  {
    throw InvalidInput("GeometricTextureTrainingOptions: Name is empty; expected a name.");
  }
  const OptionChecks check("GeometricTextureTrainingOptions");
  check.Count("FlowSteps", options.FlowSteps, 1, 1000);
  check.Weight("BaseNoiseAmplitude", options.BaseNoiseAmplitude);
  check.Count("BaseSamples", options.BaseSamples, 0, 100);
  check.Count("Projections", options.Projections, 1, 10000);
  check.Iterations("IterationsPerLevel", options.IterationsPerLevel);
  for (std::size_t k = 0; k < options.IterationsOfLevels.size(); ++k)
  {
    check.Iterations("IterationsOfLevels[" + std::to_string(k) + "]", options.IterationsOfLevels[k]);
  }
  check.Count("DiscriminatorSteps", options.DiscriminatorSteps, 1, 1000);
  check.Count("GeneratorSteps", options.GeneratorSteps, 1, 1000);
  check.LearningRate("LearningRate", options.LearningRate);
  check.Count("LearningRateInterval", options.LearningRateInterval, 0, 100000000);
  check.Factor("LearningRateFactor", options.LearningRateFactor);
  check.Weight("PenaltyWeight", options.PenaltyWeight);
  check.Count("PenaltyInterval", options.PenaltyInterval, 1, 1000);
  check.Weight("ReconstructionWeight", options.ReconstructionWeight);
}

std::vector<std::int64_t> IterationsOfEachLevel(const GeometricTextureTrainingOptions& options, std::size_t levels)
{
  if (options.IterationsOfLevels.empty())
  {
    return std::vector<std::int64_t>(levels, options.IterationsPerLevel);
  }
  if (options.IterationsOfLevels.size() != levels)
  {
    throw InvalidInput("GeometricTextureTrainingOptions: IterationsOfLevels has " +
      std::to_string(options.IterationsOfLevels.size()) + " entries; expected one for each of the " +
      std::to_string(levels) + " levels, or none.");
  }
  return options.IterationsOfLevels;
}

std::vector<double> CostsOfLevels(
  const std::vector<MultiscaleDataset>& references, const GeometricTextureOptions& network)
{
  std::vector<double> means;
  for (const MultiscaleDataset& reference : references)
  {
    const std::vector<double> costs = CostsOfLevels(reference, network);
    means.resize(costs.size(), 0.0);
    for (std::size_t level = 0; level < costs.size(); ++level)
    {
      means[level] += costs[level] / static_cast<double>(references.size());
    }
  }
  return means;
}

std::vector<double> CostsOfLevels(const MultiscaleDataset& dataset, const GeometricTextureOptions& network)
{
  constexpr double overhead = 150.0; // triangles: what each level costs besides its products, as measured on balls
  std::vector<double> costs;
  for (const TriangleMesh& mesh : dataset.Levels)
  {
    const auto level = static_cast<std::int64_t>(costs.size());
    double products = 0.0;
    for (const auto& channels : { network.GeneratorChannels(level), network.DiscriminatorChannels(level) })
    {
      for (std::size_t k = 0; k + 1 < channels.size(); ++k)
      {
        products += static_cast<double>(2 * channels[k] * channels[k + 1]);
      }
    }
    costs.push_back((static_cast<double>(mesh.NumberOfTriangles()) + overhead) * products);
  }
  return costs;
}

LossHistory GeometricTextureLossHistory()
{
  return { { "iteration", "level" },
    { "critic_loss", "gradient_penalty", "adversarial_loss", "reconstruction_loss", "learning_rate" },
    "reconstruction_loss" };
}

GeometricTextureTrainer::Internals::Internals(
  const std::vector<MultiscaleDataset>& references, const GeometricTextureTrainingOptions& options)
  : Options(options)
  , DatasetHash(HashOf(references))
  , Where(ChooseDevice(options.Device))
  , Generator(nullptr)
  , Discriminator(nullptr)
{
  const std::size_t levels = references.front().Levels.size();
  this->Options.Network = WithLevels(options.Network, levels);
  this->Options.Network.FlowSteps = options.Objective == TextureObjective::FlowMatching ? options.FlowSteps : 0;
  std::int64_t end = 0;
  for (const std::int64_t iterations : IterationsOfEachLevel(options, levels))
  {
    this->LevelEnds.push_back(end += iterations);
  }
  const GeometricTextureOptions& network = this->Options.Network;
  this->Generator = MakeGeometricTextureNetwork(
    network, false, InitialGeometricTextureTensors(network, false, options.Seed));
  this->Discriminator = MakeGeometricTextureNetwork(
    network, true, InitialGeometricTextureTensors(network, true, options.Seed));
  this->Generator->to(this->Where);
  this->Discriminator->to(this->Where);
  NormalKey key; // streams of levels begin with 1
  key.Seed = options.Seed;
  for (const MultiscaleDataset& dataset : references)
  {
    GeometricTextureReference& reference = this->References.emplace_back();
    const bool compares = options.Objective == TextureObjective::SlicedWasserstein;
    reference.Levels = MakeGeometricTextureLevels(
      dataset, this->Where, compares ? std::vector<int>{ 3, 6 } : std::vector<int>());
    reference.ReconstructionNoise = NormalPoints(
      key, reference.Levels.Template.NumberOfPoints(), network.NoiseAmplitude);
    ++key.Sample;
  }
}

std::int64_t GeometricTextureTrainer::Internals::LevelOf(std::int64_t iteration) const
{
  return std::upper_bound(this->LevelEnds.begin(), this->LevelEnds.end(), iteration) - this->LevelEnds.begin();
}

std::int64_t GeometricTextureTrainer::Internals::InLevel(std::int64_t iteration) const
{
  const auto level = static_cast<std::size_t>(this->LevelOf(iteration));
  return level == 0 ? iteration : iteration - this->LevelEnds[level - 1];
}

NormalKey GeometricTextureTrainer::Internals::KeyOfIteration() const
{
  NormalKey key = this->KeyOfLevel();
  key.Sample = static_cast<std::uint32_t>(this->InLevel(this->Done()));
  return key;
}

NormalKey GeometricTextureTrainer::Internals::KeyOfLevel() const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = static_cast<std::uint32_t>(1 + *this->Current);
  return key;
}

double GeometricTextureTrainer::Internals::LearningRateAt(std::int64_t iteration) const
{
  const auto level = static_cast<std::size_t>(this->LevelOf(iteration));
  const std::int64_t ofLevel = this->LevelEnds[level] - (level == 0 ? 0 : this->LevelEnds[level - 1]);
  const std::int64_t interval = this->Options.LearningRateInterval;
  const std::int64_t passed = this->InLevel(iteration) /
    (interval > 0 ? interval : std::max<std::int64_t>(1, ofLevel / 4));
  return this->Options.LearningRate * std::pow(this->Options.LearningRateFactor, static_cast<double>(passed));
}

bool GeometricTextureTrainer::Internals::SameChannelsAsBelow(std::int64_t level) const
{
  const GeometricTextureOptions& network = this->Options.Network;
  return level > 0 && network.GeneratorChannels(level) == network.GeneratorChannels(level - 1);
}

/// Makes new optimizers, and the tensors that stay the same while the levels below are frozen.
void GeometricTextureTrainer::Internals::BeginLevel(std::int64_t level)
{
  this->Current = level;
  this->GeneratorAdam = MakeOptimizer(this->LevelGenerator(), this->Options.LearningRate);
  this->DiscriminatorAdam = MakeOptimizer(this->Critic(), this->Options.LearningRate);
  const torch::NoGradGuard noGradients;
  if (this->Options.Objective == TextureObjective::FlowMatching)
  {
    this->SampleBases();
    return;
  }
  if (level == 0)
  {
    return;
  }
  for (this->Drawn = 0; this->Drawn < this->References.size(); ++this->Drawn)
  {
    GeometricTextureReference& reference = this->Reference();
    torch::Tensor noise = NoiseTensor(reference.ReconstructionNoise, this->Where);
    reference.ReconstructionStart = reference.Levels.Start;
    for (std::int64_t below = 0; below < level; ++below)
    {
      reference.ReconstructionStart = this->Refined(
        static_cast<std::size_t>(below), reference.ReconstructionStart, noise);
      noise = torch::Tensor();
    }
  }
  this->Drawn = 0;
}

/// Draws the reference of this iteration.
void GeometricTextureTrainer::Internals::DrawReference()
{
  constexpr std::uint32_t component = 1U << 30; // beyond those of the steps
  NormalKey key = this->KeyOfIteration();
  key.Component = component;
  const auto count = static_cast<double>(this->References.size());
  this->Drawn = std::min(this->References.size() - 1, static_cast<std::size_t>(Uniform(key, 0) * count));
}

/// The noise of one pass through the levels in this iteration; @p slot numbers the passes.
torch::Tensor GeometricTextureTrainer::Internals::Noise(std::int64_t slot, std::int64_t level)
{
  return this->Noise(slot, level, this->Options.Network.NoiseAmplitude);
}

torch::Tensor GeometricTextureTrainer::Internals::Noise(std::int64_t slot, std::int64_t level, double amplitude)
{
  NormalKey key = this->KeyOfIteration();
  key.Component = 3 * (static_cast<std::uint32_t>(slot) * MaximumNumberOfLevels + static_cast<std::uint32_t>(level));
  const std::int64_t vertices = this->Reference().Levels.Data[static_cast<std::size_t>(level)].Tables.Vertices;
  return NoiseTensor(NormalPoints(key, vertices, amplitude), this->Where);
}

/// Positions of level + 1 from those of @p level, before it is displaced.
torch::Tensor GeometricTextureTrainer::Internals::Refined(
  std::size_t level, const torch::Tensor& positions, const torch::Tensor& noise)
{
  const GeometricTextureLevelData& data = this->Reference().Levels.Data[level];
  return DoubledSubdivision(Displaced(this->Generator->Level(level), data.Tables, positions, noise), data.Parents);
}

/// Output of the levels below for fresh noise.
torch::Tensor GeometricTextureTrainer::Internals::CoarseSurface(std::int64_t slot)
{
  const torch::NoGradGuard noGradients;
  torch::Tensor positions = this->Reference().Levels.Start;
  for (std::int64_t level = 0; level < *this->Current; ++level)
  {
    positions = this->Refined(static_cast<std::size_t>(level), positions, this->Noise(slot, level));
  }
  return positions;
}

/// Losses are rounded to the precision of checkpoints, so that a table is the same with and without one.
void GeometricTextureTrainer::Internals::AppendLosses(std::int64_t iteration, const GeometricTextureLosses& losses)
{
  const auto rounded = [](double loss) { return static_cast<double>(static_cast<float>(loss)); };
  this->History.Append({ static_cast<double>(iteration + 1), static_cast<double>(this->LevelOf(iteration)),
    rounded(losses.Critic), rounded(losses.Penalty), rounded(losses.Adversarial), rounded(losses.Reconstruction),
    this->LearningRateAt(iteration) });
}

void GeometricTextureTrainer::Internals::Step()
{
  if (this->Done() >= this->Iterations())
  {
    throw InvalidInput("GeometricTextureTrainer: all " + std::to_string(this->Iterations()) +
      " iterations are done; expected no further step.");
  }
  const std::int64_t level = this->LevelOf(this->Done());
  if (this->Current != level)
  {
    if (this->SameChannelsAsBelow(level))
    {
      const auto number = static_cast<std::size_t>(level);
      CopyParameters(this->Generator->Level(number - 1), this->Generator->Level(number));
      CopyParameters(this->Discriminator->Level(number - 1), this->Discriminator->Level(number));
    }
    this->BeginLevel(level);
  }
  SetLearningRate(*this->GeneratorAdam, this->LearningRateAt(this->Done()));
  SetLearningRate(*this->DiscriminatorAdam, this->LearningRateAt(this->Done()));
  this->DrawReference();
  GeometricTextureLosses losses;
  for (std::int64_t k = 0; this->HasDiscriminator() && k < this->Options.DiscriminatorSteps; ++k)
  {
    this->DiscriminatorStep(k, losses);
  }
  for (std::int64_t k = 0; k < this->Options.GeneratorSteps; ++k)
  {
    const std::int64_t slot = this->Options.DiscriminatorSteps + k;
    this->Options.Objective == TextureObjective::FlowMatching ? this->FlowStep(slot, losses)
                                                              : this->GeneratorStep(slot, losses);
  }
  this->AppendLosses(this->Done(), losses);
}

GeometricTextureTrainer::GeometricTextureTrainer(
  MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options)
  : GeometricTextureTrainer(std::vector<MultiscaleDataset>{ std::move(dataset) }, options)
{}

GeometricTextureTrainer::GeometricTextureTrainer(
  const std::vector<MultiscaleDataset>& references, const GeometricTextureTrainingOptions& options)
{
  CheckOptions(options);
  CheckReferences(references);
  CheckOptions(WithLevels(options.Network, references.front().Levels.size()));
  this->Impl = std::make_unique<Internals>(references, options);
}

GeometricTextureTrainer::~GeometricTextureTrainer() = default;
GeometricTextureTrainer::GeometricTextureTrainer(GeometricTextureTrainer&&) noexcept = default;
GeometricTextureTrainer& GeometricTextureTrainer::operator=(GeometricTextureTrainer&&) noexcept = default;

void GeometricTextureTrainer::Step() { this->Impl->Step(); }

std::int64_t GeometricTextureTrainer::Iterations() const { return this->Impl->Iterations(); }

const LossHistory& GeometricTextureTrainer::History() const { return this->Impl->History; }

bool GeometricTextureTrainer::IsAtEndOfStage() const { return this->Impl->IsBetweenLevels(); }

std::string GeometricTextureTrainer::DeviceName() const { return NameOf(this->Impl->Where); }

std::map<std::string, std::string> GeometricTextureTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint GeometricTextureTrainer::Checkpoint() const { return this->Impl->Checkpoint(); }

void GeometricTextureTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Restore(file, checkpoint);
}

void GeometricTextureTrainer::SaveModel(const std::string& path) const { WriteGeometricTexture(path, this->Model()); }

void GeometricTextureTrainer::SaveUnfinishedModel(const std::string& path) const
{
  WriteGeometricTexture(path, this->ModelWithoutStatistics());
}

GeometricTextureModel GeometricTextureTrainer::Model() const
{
  GeometricTextureModel model = this->ModelWithoutStatistics();
  std::vector<TriangleMesh> templates;
  for (const GeometricTextureReference& reference : this->Impl->References)
  {
    templates.push_back(reference.Levels.Template);
  }
  model.Statistics = MeasureStatistics(model, templates);
  return model;
}

GeometricTextureModel GeometricTextureTrainer::ModelWithoutStatistics() const
{
  GeometricTextureModel model;
  model.Options = this->Impl->Options.Network;
  model.Name = this->Impl->Options.Name;
  model.Generator = GeometricTextureTensorsOf(*this->Impl->Generator);
  if (this->Impl->HasDiscriminator())
  {
    model.Discriminator = GeometricTextureTensorsOf(*this->Impl->Discriminator);
  }
  model.Template = this->Impl->References.front().Levels.Template;
  model.ReconstructionNoise = this->Impl->References.front().ReconstructionNoise;
  return model;
}

GeometricTextureTrainer TrainGeometricTexture(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  return TrainGeometricTexture(std::vector<MultiscaleDataset>{ std::move(dataset) }, options, files, observe, progress);
}

GeometricTextureTrainer TrainGeometricTexture(const std::vector<MultiscaleDataset>& references,
  const GeometricTextureTrainingOptions& options, const TrainingFiles& files, const TrainingObserver& observe,
  const Progress& progress)
{
  CheckFiles(files);
  GeometricTextureTrainer trainer(references, options);
  TrainAndSave(trainer, files, observe, progress);
  return trainer;
}

} // namespace surfsynth
