// SPDX-License-Identifier: BSD-3-Clause
// The steps of an iteration, by objective.
#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Learning/Losses/GeometricTextureLosses.h"
#include "Learning/Training/GeometricTextureTrainerInternals.h"
#include "Learning/Training/NetworkTraining.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
/// Components of the random numbers of a step, by the step: beyond those of the noise.
constexpr std::uint32_t DirectionComponent = 1U << 29;
constexpr std::uint32_t TimeComponent = DirectionComponent + (1U << 28);
constexpr std::uint32_t BaseComponent = DirectionComponent + (1U << 27);
constexpr std::uint32_t SampleComponent = DirectionComponent + (1U << 26);
/// Of samples near the reference: restarts, and steps of half of the flow.
constexpr int SampleRestarts = 2;
constexpr int SampleSteps = 5;

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
} // namespace

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

/// True in steps of the discriminator, numbered from 0 in each iteration, that have a gradient penalty.
bool GeometricTextureTrainer::Internals::HasPenalty(std::int64_t slot) const
{
  const std::int64_t step = this->InLevel(this->Done()) * this->Options.DiscriminatorSteps + slot;
  return step % this->Options.PenaltyInterval == 0;
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
  this->DiscriminatorAdam->zero_grad();
  const double share = 1.0 / static_cast<double>(this->Options.DiscriminatorSteps);
  if (this->HasPenalty(slot))
  {
    NormalKey key = this->KeyOfIteration();
    key.Component = static_cast<std::uint32_t>(slot);
    const torch::Tensor penalty = GradientPenalty(
      this->Critic(), data.Tables, data.RealFeatures, fake, Uniform(key, 0));
    (static_cast<double>(this->Options.PenaltyInterval) * this->Options.PenaltyWeight * penalty).backward();
    std::int64_t penalties = 0; // of this iteration
    for (std::int64_t k = 0; k < this->Options.DiscriminatorSteps; ++k)
    {
      penalties += this->HasPenalty(k) ? 1 : 0;
    }
    losses.Penalty += penalty.item<double>() / static_cast<double>(penalties);
  }
  const torch::Tensor difference = CriticValue(this->Critic(), data.Tables, fake) -
    CriticValue(this->Critic(), data.Tables, data.RealFeatures);
  difference.backward();
  losses.Critic += share * difference.item<double>();
  this->TakeStep(*this->DiscriminatorAdam, this->Critic(), losses.Critic + losses.Penalty);
}

/// Random directions of unit length, [channels, P], of a step.
torch::Tensor GeometricTextureTrainer::Internals::Directions(std::int64_t slot, std::int64_t channels) const
{
  NormalKey key = this->KeyOfIteration();
  key.Component = DirectionComponent + static_cast<std::uint32_t>(slot);
  Eigen::VectorXd normals(channels * this->Options.Projections);
  FillNormals(key, 0, normals.size(), normals.data());
  const torch::Tensor directions = torch::from_blob(
    normals.data(), { channels, this->Options.Projections }, torch::kFloat64)
                                     .to(this->Where, torch::kFloat32, false, true);
  return directions / directions.norm(2, 0, true);
}

/// Ids of all of @p count rows, or of 1,024 to 2,047 of more, evenly spaced from a random one on. @param point number of the draw
torch::Tensor GeometricTextureTrainer::Internals::SomeRows(
  std::int64_t slot, std::int64_t point, std::int64_t count) const
{
  constexpr std::int64_t most = 1024;
  NormalKey key = this->KeyOfIteration();
  key.Component = static_cast<std::uint32_t>(slot);
  const std::int64_t stride = std::max<std::int64_t>(1, count / most);
  const auto first = static_cast<std::int64_t>(Uniform(key, point) * static_cast<double>(stride));
  return torch::arange(first, count, stride, torch::TensorOptions(torch::kInt64).device(this->Where));
}

/// Sum of the distances of all neighborhoods from those of the reference, over some of the triangles and vertices.
torch::Tensor GeometricTextureTrainer::Internals::SlicedDistance(std::int64_t slot, const torch::Tensor& positions)
{
  const GeometricTextureLevelData& data = this->Data();
  const torch::Tensor faces = this->SomeRows(slot, 0, data.RealFeatures.size(0));
  const torch::Tensor edges = AllEdgeOrders(EdgeFeatureTensor(data.Tables, positions).index_select(0, faces));
  torch::Tensor sum = SlicedWassersteinLoss(
    edges, AllEdgeOrders(data.RealFeatures.index_select(0, faces)), this->Directions(slot, edges.size(1)));
  for (std::size_t k = 0; k < data.Rings.size(); ++k)
  {
    const torch::Tensor rows = this->SomeRows(slot, static_cast<std::int64_t>(k) + 1, data.Rings[k].Centers.size(0));
    const torch::Tensor features = RingFeatureTensor(data.Tables, data.Rings[k].Take(rows), positions);
    sum = sum +
      SlicedWassersteinLoss(
        features, data.RealRingFeatures[k].index_select(0, rows), this->Directions(slot, features.size(1)));
  }
  return sum;
}

/// What the generator lowers beside the reconstruction.
torch::Tensor GeometricTextureTrainer::Internals::AdversarialLoss(std::int64_t slot, const torch::Tensor& positions)
{
  const FaceTables& tables = this->Data().Tables;
  return this->HasDiscriminator() ? -CriticValue(this->Critic(), tables, EdgeFeatureTensor(tables, positions))
                                  : this->SlicedDistance(slot, positions);
}

void GeometricTextureTrainer::Internals::GeneratorStep(std::int64_t slot, GeometricTextureLosses& losses)
{
  const GeometricTextureLevelData& data = this->Data();
  const std::int64_t level = *this->Current;
  GeometricTextureLevelNetworkImpl& generator = this->LevelGenerator();
  const Frozen critic(this->Critic());
  this->GeneratorAdam->zero_grad();
  const torch::Tensor fake = Displaced(generator, data.Tables, this->CoarseSurface(slot), this->Noise(slot, level));
  const torch::Tensor adversarial = this->AdversarialLoss(slot, fake);
  // Level 0 reconstructs from any noise, those above from one: the passes of both kinds have numbers of their own.
  const std::int64_t fresh = slot + this->Options.GeneratorSteps;
  const torch::Tensor reconstructed = level == 0
    ? Displaced(generator, data.Tables, this->Reference().Levels.Start, this->Noise(fresh, 0))
    : Displaced(generator, data.Tables, this->Reference().ReconstructionStart);
  const torch::Tensor reconstruction = ReconstructionLoss(reconstructed, data.Real);
  (this->Options.ReconstructionWeight * reconstruction + adversarial).backward();
  const double share = 1.0 / static_cast<double>(this->Options.GeneratorSteps);
  losses.Adversarial += share * adversarial.item<double>();
  losses.Reconstruction += share * reconstruction.item<double>();
  this->TakeStep(*this->GeneratorAdam, generator, losses.Adversarial + losses.Reconstruction);
}

/// A sample of the level before, [V, 3], with features where the reference has them: restarts of its flow [Meng2022].
torch::Tensor GeometricTextureTrainer::Internals::NearReference(std::int64_t sample)
{
  const auto below = static_cast<std::size_t>(*this->Current - 1);
  const GeometricTextureLevels& levels = this->Reference().Levels;
  const GeometricTextureLevelData& data = levels.Data[below];
  const torch::Tensor base = below == 0
    ? levels.Start
    : DoubledSubdivision(levels.Data[below - 1].Real, levels.Data[below - 1].Parents);
  NormalKey key = this->KeyOfLevel();
  key.Component = SampleComponent + 3 * SampleRestarts * static_cast<std::uint32_t>(sample);
  torch::Tensor offset = data.Real - base;
  for (int restart = 0; restart < SampleRestarts; ++restart, key.Component += 3)
  {
    const SinglePoints noise = NormalPoints(key, data.Tables.Vertices, this->Options.Network.NoiseAmplitude);
    offset = 0.5 * (offset + NoiseTensor(noise, this->Where));
    for (int step = 0; step < SampleSteps; ++step)
    {
      const torch::Tensor velocity = Displaced(this->Generator->Level(below), data.Tables, base, offset) - base;
      offset = offset + velocity / (2.0 * SampleSteps);
    }
  }
  return base + offset;
}

/// Draws samples of the level before, near each reference.
void GeometricTextureTrainer::Internals::SampleBases()
{
  for (this->Drawn = 0; this->Drawn < this->References.size(); ++this->Drawn)
  {
    this->Reference().Bases.clear();
    for (std::int64_t k = 0; *this->Current > 0 && k < this->Options.BaseSamples; ++k)
    {
      this->Reference().Bases.push_back(this->NearReference(k));
    }
  }
  this->Drawn = 0;
}

/// The level before, subdivided: what a flow displaces. Above level 0 one of its samples, with noise: in a synthesis it is
/// never the reference's.
torch::Tensor GeometricTextureTrainer::Internals::FlowBase(std::int64_t slot)
{
  if (*this->Current == 0)
  {
    return this->Reference().Levels.Start;
  }
  const std::int64_t below = *this->Current - 1;
  const GeometricTextureLevelData& data = this->Reference().Levels.Data[static_cast<std::size_t>(below)];
  const std::vector<torch::Tensor>& bases = this->Reference().Bases;
  NormalKey key = this->KeyOfIteration();
  key.Component = BaseComponent + static_cast<std::uint32_t>(slot);
  const double amplitude = this->Options.BaseNoiseAmplitude * Uniform(key, 0);
  const auto count = static_cast<std::int64_t>(bases.size());
  const torch::Tensor& before = bases.empty() ? data.Real
                                              : bases[static_cast<std::size_t>(UniformIndex(key, 1, count))];
  return DoubledSubdivision(before + this->Noise(slot, below, amplitude), data.Parents);
}

/// Of one step with noise of its own, from the level before.
void GeometricTextureTrainer::Internals::FlowStep(std::int64_t slot, GeometricTextureLosses& losses)
{
  const GeometricTextureLevelData& data = this->Data();
  GeometricTextureLevelNetworkImpl& generator = this->LevelGenerator();
  this->GeneratorAdam->zero_grad();
  const torch::Tensor base = this->FlowBase(slot);
  const torch::Tensor noise = this->Noise(slot, *this->Current);
  NormalKey key = this->KeyOfIteration();
  key.Component = TimeComponent + static_cast<std::uint32_t>(slot);
  const double time = Uniform(key, 0);
  const torch::Tensor state = (1.0 - time) * noise + time * (data.Real - base);
  const torch::Tensor loss = ReconstructionLoss(Displaced(generator, data.Tables, base, state), data.Real - noise);
  loss.backward();
  losses.Reconstruction += loss.item<double>() / static_cast<double>(this->Options.GeneratorSteps);
  this->TakeStep(*this->GeneratorAdam, generator, losses.Reconstruction);
}

} // namespace surfsynth
