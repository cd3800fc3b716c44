// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/GeometricTextureTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Learning/Losses/GeometricTextureLosses.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/GeometricTextureTrainerInternals.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"

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

/// Standard normals times @p amplitude, [vertices, 3] in float32; coordinates are components from that of @p key on.
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

/// While it lives, a network's parameters are constants.
class Frozen
{
public:
  explicit Frozen(torch::nn::Module& network)
    : Parameters(network.parameters())
  {
    this->Set(false);
  }
  ~Frozen() { this->Set(true); }
  Frozen(const Frozen&) = delete;
  Frozen& operator=(const Frozen&) = delete;

private:
  void Set(bool trainable)
  {
    for (torch::Tensor& parameter : this->Parameters)
    {
      parameter.set_requires_grad(trainable);
    }
  }
  std::vector<torch::Tensor> Parameters;
};

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

void CheckOptions(const GeometricTextureTrainingOptions& options)
{
  CheckOptions(options.Network);
  if (options.Name.empty())
  {
    throw InvalidInput("GeometricTextureTrainingOptions: Name is empty; expected a name.");
  }
  const OptionChecks check("GeometricTextureTrainingOptions");
  check.Iterations("IterationsPerLevel", options.IterationsPerLevel);
  check.Count("DiscriminatorSteps", options.DiscriminatorSteps, 1, 1000);
  check.Count("GeneratorSteps", options.GeneratorSteps, 1, 1000);
  check.LearningRate("LearningRate", options.LearningRate);
  check.Iterations("LearningRateInterval", options.LearningRateInterval);
  check.Factor("LearningRateFactor", options.LearningRateFactor);
  check.Weight("PenaltyWeight", options.PenaltyWeight);
  check.Weight("ReconstructionWeight", options.ReconstructionWeight);
}

std::vector<double> CostsOfLevels(const MultiscaleDataset& dataset, const GeometricTextureOptions& network)
{
  constexpr double overhead = 1000.0; // triangles: an estimate of what each level costs besides its products
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
  const MultiscaleDataset& dataset, const GeometricTextureTrainingOptions& options)
  : Options(options)
  , DatasetHash(ContentHash(dataset))
  , Where(ChooseDevice(options.Device))
  , Levels(MakeGeometricTextureLevels(dataset, this->Where))
  , Generator(nullptr)
  , Discriminator(nullptr)
{
  this->Options.Network = WithLevels(options.Network, dataset.Levels.size());
  const GeometricTextureOptions& network = this->Options.Network;
  this->Generator = MakeGeometricTextureNetwork(
    network, false, InitialGeometricTextureTensors(network, false, options.Seed));
  this->Discriminator = MakeGeometricTextureNetwork(
    network, true, InitialGeometricTextureTensors(network, true, options.Seed));
  this->Generator->to(this->Where);
  this->Discriminator->to(this->Where);
  NormalKey key; // streams of levels begin with 1
  key.Seed = options.Seed;
  this->ReconstructionNoise = NormalPoints(key, this->Levels.Template.NumberOfPoints(), network.NoiseAmplitude);
}

double GeometricTextureTrainer::Internals::LearningRateAt(std::int64_t iteration) const
{
  const std::int64_t passed = iteration % this->Options.IterationsPerLevel / this->Options.LearningRateInterval;
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
  if (level == 0)
  {
    return;
  }
  const torch::NoGradGuard noGradients;
  torch::Tensor noise = NoiseTensor(this->ReconstructionNoise, this->Where);
  this->ReconstructionStart = this->Levels.Start;
  for (std::int64_t below = 0; below < level; ++below)
  {
    this->ReconstructionStart = this->Refined(static_cast<std::size_t>(below), this->ReconstructionStart, noise);
    noise = torch::Tensor();
  }
}

/// The noise of one pass through the levels in this iteration; @p slot numbers the passes.
torch::Tensor GeometricTextureTrainer::Internals::Noise(std::int64_t slot, std::int64_t level) const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = static_cast<std::uint32_t>(1 + *this->Current);
  key.Sample = static_cast<std::uint32_t>(this->Done() % this->Options.IterationsPerLevel);
  key.Component = 3 * (static_cast<std::uint32_t>(slot) * MaximumNumberOfLevels + static_cast<std::uint32_t>(level));
  const std::int64_t vertices = this->Levels.Data[static_cast<std::size_t>(level)].Tables.Vertices;
  return NoiseTensor(NormalPoints(key, vertices, this->Options.Network.NoiseAmplitude), this->Where);
}

/// Positions of level + 1 from those of @p level, before it is displaced.
torch::Tensor GeometricTextureTrainer::Internals::Refined(
  std::size_t level, const torch::Tensor& positions, const torch::Tensor& noise)
{
  const GeometricTextureLevelData& data = this->Levels.Data[level];
  return DoubledSubdivision(Displaced(this->Generator->Level(level), data.Tables, positions, noise), data.Parents);
}

/// Output of the levels below for fresh noise.
torch::Tensor GeometricTextureTrainer::Internals::CoarseSurface(std::int64_t slot)
{
  const torch::NoGradGuard noGradients;
  torch::Tensor positions = this->Levels.Start;
  for (std::int64_t level = 0; level < *this->Current; ++level)
  {
    positions = this->Refined(static_cast<std::size_t>(level), positions, this->Noise(slot, level));
  }
  return positions;
}

void GeometricTextureTrainer::Internals::TakeStep(
  torch::optim::Adam& optimizer, const torch::nn::Module& network, double loss) const
{
  const double unlimited = std::numeric_limits<double>::infinity();
  if (!std::isfinite(loss) || !std::isfinite(torch::nn::utils::clip_grad_norm_(network.parameters(), unlimited)))
  {
    throw SolverFailure("A loss or its gradient is not finite in iteration " + std::to_string(this->Done() + 1) +
      " of the training; expected a lower learning rate, or meshes without needles.");
  }
  optimizer.step();
  RequireFiniteWeights(network.parameters(), this->Done() + 1);
}

void GeometricTextureTrainer::Internals::DiscriminatorStep(std::int64_t slot, GeometricTextureLosses& losses)
{
  const GeometricTextureLevelData& data = this->Data();
  torch::Tensor fake;
  {
    const torch::NoGradGuard noGradients;
    fake = EdgeFeatureTensor(data.Tables,
      Displaced(this->LevelGenerator(), data.Tables, this->CoarseSurface(slot), this->Noise(slot, *this->Current)));
  }
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = static_cast<std::uint32_t>(1 + *this->Current);
  key.Sample = static_cast<std::uint32_t>(this->Done() % this->Options.IterationsPerLevel);
  key.Component = static_cast<std::uint32_t>(slot);
  this->DiscriminatorAdam->zero_grad();
  const torch::Tensor penalty = GradientPenalty(this->Critic(), data.Tables, data.RealFeatures, fake, Uniform(key, 0));
  (this->Options.PenaltyWeight * penalty).backward();
  const torch::Tensor difference = CriticValue(this->Critic(), data.Tables, fake) -
    CriticValue(this->Critic(), data.Tables, data.RealFeatures);
  difference.backward();
  const double share = 1.0 / static_cast<double>(this->Options.DiscriminatorSteps);
  losses.Critic += share * difference.item<double>();
  losses.Penalty += share * penalty.item<double>();
  this->TakeStep(*this->DiscriminatorAdam, this->Critic(), losses.Critic + losses.Penalty);
}

void GeometricTextureTrainer::Internals::GeneratorStep(std::int64_t slot, GeometricTextureLosses& losses)
{
  const GeometricTextureLevelData& data = this->Data();
  const std::int64_t level = *this->Current;
  GeometricTextureLevelNetworkImpl& generator = this->LevelGenerator();
  const Frozen critic(this->Critic());
  this->GeneratorAdam->zero_grad();
  const torch::Tensor fake = Displaced(generator, data.Tables, this->CoarseSurface(slot), this->Noise(slot, level));
  const torch::Tensor adversarial = -CriticValue(this->Critic(), data.Tables, EdgeFeatureTensor(data.Tables, fake));
  // Level 0 reconstructs from any noise, those above from one: the passes of both kinds have numbers of their own.
  const std::int64_t fresh = slot + this->Options.GeneratorSteps;
  const torch::Tensor reconstructed = level == 0
    ? Displaced(generator, data.Tables, this->Levels.Start, this->Noise(fresh, 0))
    : Displaced(generator, data.Tables, this->ReconstructionStart);
  const torch::Tensor reconstruction = ReconstructionLoss(reconstructed, data.Real);
  (this->Options.ReconstructionWeight * reconstruction + adversarial).backward();
  const double share = 1.0 / static_cast<double>(this->Options.GeneratorSteps);
  losses.Adversarial += share * adversarial.item<double>();
  losses.Reconstruction += share * reconstruction.item<double>();
  this->TakeStep(*this->GeneratorAdam, generator, losses.Adversarial + losses.Reconstruction);
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
  GeometricTextureLosses losses;
  for (std::int64_t k = 0; k < this->Options.DiscriminatorSteps; ++k)
  {
    this->DiscriminatorStep(k, losses);
  }
  for (std::int64_t k = 0; k < this->Options.GeneratorSteps; ++k)
  {
    this->GeneratorStep(this->Options.DiscriminatorSteps + k, losses);
  }
  this->AppendLosses(this->Done(), losses);
}

GeometricTextureTrainer::GeometricTextureTrainer(
  MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options)
{
  CheckOptions(options);
  CheckDataset(dataset);
  CheckOptions(WithLevels(options.Network, dataset.Levels.size()));
  this->Impl = std::make_unique<Internals>(dataset, options);
}

GeometricTextureTrainer::~GeometricTextureTrainer() = default;
GeometricTextureTrainer::GeometricTextureTrainer(GeometricTextureTrainer&&) noexcept = default;
GeometricTextureTrainer& GeometricTextureTrainer::operator=(GeometricTextureTrainer&&) noexcept = default;

void GeometricTextureTrainer::Step() { this->Impl->Step(); }

std::int64_t GeometricTextureTrainer::Iterations() const { return this->Impl->Iterations(); }

const LossHistory& GeometricTextureTrainer::History() const { return this->Impl->History; }

bool GeometricTextureTrainer::IsAtEndOfStage() const
{
  return this->Impl->Done() % this->Impl->Options.IterationsPerLevel == 0;
}

std::string GeometricTextureTrainer::DeviceName() const { return NameOf(this->Impl->Where); }

std::map<std::string, std::string> GeometricTextureTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint GeometricTextureTrainer::Checkpoint() const { return this->Impl->Checkpoint(); }

void GeometricTextureTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Restore(file, checkpoint);
}

void GeometricTextureTrainer::SaveModel(const std::string& path) const { WriteGeometricTexture(path, this->Model()); }

GeometricTextureModel GeometricTextureTrainer::Model() const
{
  GeometricTextureModel model;
  model.Options = this->Impl->Options.Network;
  model.Name = this->Impl->Options.Name;
  model.Generator = GeometricTextureTensorsOf(*this->Impl->Generator);
  model.Discriminator = GeometricTextureTensorsOf(*this->Impl->Discriminator);
  model.Template = this->Impl->Levels.Template;
  model.ReconstructionNoise = this->Impl->ReconstructionNoise;
  model.Statistics = MeasureStatistics(model);
  return model;
}

GeometricTextureTrainer TrainGeometricTexture(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  GeometricTextureTrainer trainer(std::move(dataset), options);
  TrainAndSave(trainer, files, observe, progress);
  return trainer;
}

} // namespace surfsynth
