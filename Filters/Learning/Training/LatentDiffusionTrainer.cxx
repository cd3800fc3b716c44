// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/LatentDiffusionTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/FieldLatents/LatentDiffusionSampler.h"
#include "Learning/Losses/LatentDiffusionLosses.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Networks/LatentDiffusionNetworks.h"
#include "Learning/Training/ComplexMuon.h"
#include "Learning/Training/FlatParameters.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/TimeLosses.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
// Streams of random numbers.
constexpr std::uint32_t ChoiceStream = 10;    ///< times, surfaces, dropout
constexpr std::uint32_t DiffusionStream = 11; ///< noise of the diffusion
constexpr std::uint32_t PosteriorStream = 12; ///< samples of the latents
constexpr std::uint32_t ScaleStream = 13;     ///< samples of the latents for their scale

static_assert(LatentDiffusionTrainer::NumberOfTimeBins == NumberOfTimeLosses);

LossHistory DiffusionLossHistory()
{
  std::vector<std::string> values = { "loss", "gradient_norm", "learning_rate" };
  AppendTimeColumns(values, "noise_loss_");
  return { { "iteration" }, values, "loss" };
}

/// Standard normal numbers [rows, columns].
torch::Tensor NormalTensor(const NormalKey& key, std::int64_t rows, std::int64_t columns)
{
  const torch::Tensor numbers = torch::empty({ rows, columns }, torch::kFloat64);
  FillNormals(key, 0, numbers.numel(), numbers.data_ptr<double>());
  return numbers.to(torch::kFloat32);
}

torch::Tensor ColumnsTensor(const LatentColumns& columns)
{
  return torch::from_blob(const_cast<float*>(columns.data()), { columns.rows(), columns.cols() }, torch::kFloat32)
    .clone();
}

/// Choices for one surface of an iteration.
struct DiffusionDraw
{
  std::int64_t Surface;
  int Time;    ///< 1 to T
  bool Guided; ///< true to show labels and directions
};
} // namespace

void CheckOptions(const LatentDiffusionTrainingOptions& options)
{
  CheckOptions(options.Network);
  const OptionChecks check("LatentDiffusionTrainingOptions");
  check.Iterations("Iterations", options.Iterations);
  check.Count("BatchSize", options.BatchSize, 1, 1000000);
  check.LearningRate("LearningRate", options.LearningRate);
  check.LearningRate("FinalLearningRate", options.FinalLearningRate);
  check.Weight("GradientClip", options.GradientClip);
  check.Require(options.WeightAveraging >= 0.0 && options.WeightAveraging < 1.0, "WeightAveraging",
    options.WeightAveraging, "a number in [0, 1)");
  check.Weight("SnrLimit", options.SnrLimit);
  check.Require(options.ConditionDropout >= 0.0 && options.ConditionDropout <= 1.0, "ConditionDropout",
    options.ConditionDropout, "a number in [0, 1]");
}

class LatentDiffusionTrainer::Internals
{
public:
  Internals(const LatentDataset& dataset, const LatentDiffusionTrainingOptions& options)
    : Options(options)
    , Schedule(options.Network.TimeSteps, options.Network.FirstVariance, options.Network.LastVariance)
    , Hash(ContentHash(dataset))
    , Autoencoder(dataset.Autoencoder)
    , Where(ChooseDevice(options.Device))
    , Network(MakeLatentDenoisingNetwork(InitialLatentDiffusion(options.Network, options.Seed)))
  {
    for (const LatentSurface& surface : dataset.Surfaces)
    {
      this->Surfaces.push_back(MakeSurface(surface, this->Surfaces.size()));
      this->Vertices += surface.Mesh.NumberOfPoints();
    }
    this->ScaleLatents();
    this->Network->to(this->Where);
    this->Weights = std::make_unique<FlatParameters>(*this->Network);
    this->Average = this->Weights->Values().detach().clone();
    this->Adam = std::make_unique<torch::optim::Adam>(
      std::vector<torch::Tensor>{ this->Weights->Values() }, torch::optim::AdamOptions(options.LearningRate));
    this->Matrices = std::make_unique<ComplexMuon>(
      options.Optimizer == TrainingOptimizer::Muon ? this->Network->parameters() : std::vector<torch::Tensor>());
  }

  void Step();
  std::map<std::string, std::string> Recipe() const;
  TrainingCheckpoint Checkpoint();
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint);
  LatentDiffusionModel Model();
  std::int64_t Done() const { return static_cast<std::int64_t>(this->History.Size()); }

  LatentDiffusionTrainingOptions Options;
  torch::Device Device() const { return this->Where; }
  LossHistory History = DiffusionLossHistory();

private:
  /// A surface under training.
  struct Surface
  {
    std::shared_ptr<const DiffusionSurface> Levels;
    torch::Tensor Means;      ///< [V, 2 d], scaled
    torch::Tensor Deviations; ///< [V, 2 d], scaled
  };

  static Surface MakeSurface(const LatentSurface& surface, std::size_t number);
  double LearningRate() const;
  void ScaleLatents();
  DiffusionDraw Draw(std::int64_t slot) const;
  torch::Tensor Latents(std::int64_t slot, const Surface& surface) const;
  double Accumulate(std::int64_t slot, TimeLosses& noiseLosses);
  void MoveWeights(double learningRate);
  void UpdateAverage();
  bool IsOfMuon(const torch::Tensor& parameter) const;
  NormalKey Key(std::uint32_t stream, std::int64_t slot) const;

  DiffusionSchedule Schedule;
  std::uint64_t Hash;
  std::string Autoencoder;   ///< of the dataset
  std::int64_t Vertices = 0; ///< of all surfaces
  torch::Device Where;
  std::vector<Surface> Surfaces;
  std::vector<float> Scale; ///< [d], equation 39
  LatentDenoisingNetwork Network;
  std::unique_ptr<FlatParameters> Weights;
  torch::Tensor Average;                    ///< of all parameters
  std::unique_ptr<torch::optim::Adam> Adam; ///< of all weights
  std::unique_ptr<ComplexMuon> Matrices;    ///< those whose gradients Adam does not see
};

/// Levels and Gaussians of a surface, before they are scaled.
LatentDiffusionTrainer::Internals::Surface LatentDiffusionTrainer::Internals::MakeSurface(
  const LatentSurface& surface, std::size_t number)
{
  LatentDiffusionConditions conditions;
  conditions.Labels = surface.Labels;
  conditions.Directions = surface.Directions;
  const torch::Tensor deviations = ColumnsTensor(surface.Deviations);
  try
  {
    return { std::make_shared<const DiffusionSurface>(TangentHierarchy(OneRings(surface.Mesh)), conditions),
      ColumnsTensor(surface.Means), deviations.repeat_interleave(2, 1) };
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("LatentDiffusionTrainer: surface " + std::to_string(number) + ": " + error.what());
  }
}

/// Random numbers of this iteration.
NormalKey LatentDiffusionTrainer::Internals::Key(std::uint32_t stream, std::int64_t slot) const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = stream;
  key.Sample = static_cast<std::uint32_t>(this->Done());
  key.Component = static_cast<std::uint32_t>(slot);
  return key;
}

double LatentDiffusionTrainer::Internals::LearningRate() const
{
  constexpr double pi = 3.14159265358979323846;
  const double part = static_cast<double>(this->Done()) / static_cast<double>(this->Options.Iterations);
  const double start = 100.0 * (part + 1.0 / static_cast<double>(this->Options.Iterations));
  const double risen = this->Options.Optimizer == TrainingOptimizer::Muon ? std::min(1.0, start) : 1.0;
  const double fall = this->Options.LearningRate - this->Options.FinalLearningRate;
  return risen * (this->Options.FinalLearningRate + 0.5 * fall * (1.0 + std::cos(pi * std::min(part, 1.0))));
}

/// Equation 39 over all surfaces.
void LatentDiffusionTrainer::Internals::ScaleLatents()
{
  std::vector<torch::Tensor> samples;
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = ScaleStream;
  for (const Surface& surface : this->Surfaces)
  {
    const torch::Tensor& means = surface.Means;
    samples.push_back(this->Options.SampleLatents
        ? means + surface.Deviations * NormalTensor(key, means.size(0), means.size(1))
        : means);
    ++key.Sample;
  }
  const torch::Tensor all = torch::cat(samples);
  this->Scale = LatentScale(Eigen::Map<const FieldLatentMatrix>(all.data_ptr<float>(), all.size(0), all.size(1)));
  const torch::Tensor factors = torch::tensor(this->Scale).repeat_interleave(2);
  for (Surface& surface : this->Surfaces)
  {
    surface.Means = surface.Means * factors;
    surface.Deviations = surface.Deviations * factors;
  }
}

/// Surface, time and guidance of one place of the batch.
DiffusionDraw LatentDiffusionTrainer::Internals::Draw(std::int64_t slot) const
{
  const double shift = static_cast<double>(slot) / static_cast<double>(this->Options.BatchSize);
  const double turn = Uniform(this->Key(ChoiceStream, 0), 0) + shift;
  const double part = turn - std::floor(turn);
  const NormalKey key = this->Key(ChoiceStream, slot + 1);
  DiffusionDraw draw;
  draw.Time = 1 +
    static_cast<int>(std::min(part * static_cast<double>(this->Schedule.Steps()), this->Schedule.Steps() - 1.0));
  draw.Surface = UniformIndex(key, 0, static_cast<std::int64_t>(this->Surfaces.size()));
  draw.Guided = Uniform(key, 1) >= this->Options.ConditionDropout;
  return draw;
}

/// Scaled latents of a surface in this iteration, [V, 2 d].
torch::Tensor LatentDiffusionTrainer::Internals::Latents(std::int64_t slot, const Surface& surface) const
{
  if (!this->Options.SampleLatents)
  {
    return surface.Means;
  }
  const torch::Tensor normals = NormalTensor(
    this->Key(PosteriorStream, slot), surface.Means.size(0), surface.Means.size(1));
  return surface.Means + surface.Deviations * normals;
}

/// Adds the gradients of the share of one surface in the loss, and the loss of its noise by time. Returns its loss.
double LatentDiffusionTrainer::Internals::Accumulate(std::int64_t slot, TimeLosses& noiseLosses)
{
  const DiffusionDraw draw = this->Draw(slot);
  const Surface& surface = this->Surfaces[static_cast<std::size_t>(draw.Surface)];
  const DiffusionTarget target = this->Options.Network.Target;
  const double alpha = this->Schedule.Alpha(draw.Time);
  const torch::Tensor data = this->Latents(slot, surface).to(this->Where);
  const torch::Tensor noise =
    NormalTensor(this->Key(DiffusionStream, slot), data.size(0), data.size(1)).to(this->Where);
  const torch::Tensor state = std::sqrt(alpha) * data + std::sqrt(1.0 - alpha) * noise;
  const torch::Tensor prediction = this->Network->forward(state, draw.Time, surface.Levels, draw.Guided);
  const torch::Tensor error = (prediction - DenoisingTarget(target, alpha, data, noise)).square().mean();
  const double weight = DenoisingWeight(target, alpha, this->Options.SnrLimit);
  (error * (weight / static_cast<double>(this->Options.BatchSize))).backward();
  const double squared = error.item<double>();
  const auto bin = static_cast<std::size_t>(
    (static_cast<std::int64_t>(draw.Time) * static_cast<std::int64_t>(NumberOfTimeLosses) - 1) /
    this->Schedule.Steps());
  noiseLosses[std::min(bin, NumberOfTimeLosses - 1)].push_back(NoiseErrorFactor(target, alpha) * squared);
  return weight * squared;
}

bool LatentDiffusionTrainer::Internals::IsOfMuon(const torch::Tensor& parameter) const
{
  return this->Options.Optimizer == TrainingOptimizer::Muon && ComplexMuon::Moves(parameter);
}

/// One step of the optimizer.
void LatentDiffusionTrainer::Internals::MoveWeights(double learningRate)
{
  this->Matrices->TakeGradients();
  static_cast<torch::optim::AdamOptions&>(this->Adam->param_groups()[0].options()).lr(learningRate);
  this->Adam->step();
  this->Matrices->Step(learningRate);
}

void LatentDiffusionTrainer::Internals::UpdateAverage()
{
  const torch::NoGradGuard noGradients;
  const auto done = static_cast<double>(this->Done());
  const double keep = std::min(this->Options.WeightAveraging, (1.0 + done) / (10.0 + done));
  this->Average.mul_(keep).add_(this->Weights->Values(), 1.0 - keep);
}

void LatentDiffusionTrainer::Internals::Step()
{
  const std::int64_t iteration = this->Done() + 1;
  const double learningRate = this->LearningRate();
  this->Weights->ZeroGradients();
  double loss = 0.0;
  TimeLosses noiseLosses;
  for (std::int64_t slot = 0; slot < this->Options.BatchSize; ++slot)
  {
    loss += this->Accumulate(slot, noiseLosses) / static_cast<double>(this->Options.BatchSize);
  }
  const double gradientNorm = this->Weights->ClipGradients(this->Options.GradientClip);
  if (!std::isfinite(loss) || !std::isfinite(gradientNorm))
  {
    throw SolverFailure("The loss or its gradient is not finite in iteration " + std::to_string(iteration) +
      " of the training; expected a lower learning rate.");
  }
  this->MoveWeights(learningRate);
  RequireFiniteWeights({ this->Weights->Values() }, iteration);
  this->UpdateAverage();
  std::vector<double> row = { static_cast<double>(iteration), loss, gradientNorm, learningRate };
  AppendTimeMeans(noiseLosses, this->History, row);
  this->History.Append(row);
}

std::map<std::string, std::string> LatentDiffusionTrainer::Internals::Recipe() const
{
  const LatentDiffusionTrainingOptions& o = this->Options;
  std::map<std::string, std::string> recipe = { { "training", "latent_diffusion" },
    { "latent_dimension", std::to_string(o.Network.LatentDimension) },
    { "channels", std::to_string(o.Network.Channels) }, { "coarse_channels", std::to_string(o.Network.CoarseChannels) },
    { "input_blocks", std::to_string(o.Network.InputBlocks) },
    { "coarse_blocks", std::to_string(o.Network.CoarseBlocks) },
    { "output_blocks", std::to_string(o.Network.OutputBlocks) },
    { "embedding_dimension", std::to_string(o.Network.EmbeddingDimension) },
    { "labels", std::to_string(o.Network.NumberOfLabels) }, { "directed", o.Network.Directed ? "yes" : "no" },
    { "time_steps", std::to_string(o.Network.TimeSteps) }, { "first_variance", FormatExact(o.Network.FirstVariance) },
    { "last_variance", FormatExact(o.Network.LastVariance) }, { "target", NameOf(o.Network.Target) },
    { "batch_size", std::to_string(o.BatchSize) }, { "learning_rate", FormatExact(o.LearningRate) },
    { "final_learning_rate", FormatExact(o.FinalLearningRate) }, { "gradient_clip", FormatExact(o.GradientClip) },
    { "weight_averaging", FormatExact(o.WeightAveraging) }, { "snr_limit", FormatExact(o.SnrLimit) },
    { "condition_dropout", FormatExact(o.ConditionDropout) }, { "sample_latents", o.SampleLatents ? "yes" : "no" },
    { "seed", std::to_string(o.Seed) }, { "dataset", std::to_string(this->Hash) } };
  if (o.Optimizer == TrainingOptimizer::Muon) // no entry in recipes of earlier versions
  {
    recipe["optimizer"] = "muon";
  }
  return recipe;
}

TrainingCheckpoint LatentDiffusionTrainer::Internals::Checkpoint()
{
  TrainingCheckpoint checkpoint;
  for (std::int64_t k = 0; k < this->Done(); ++k)
  {
    // Checkpoints have two columns that this training does without.
    const std::vector<double>& row = this->History.Row(static_cast<std::size_t>(k));
    checkpoint.History.Append({ row[0], row[1], 0.0, 0.0, row[2], row[3] });
  }
  checkpoint.Tensors[TimeLossesName] = TimeColumns(this->History);
  for (const auto& parameter : this->Network->named_parameters())
  {
    checkpoint.Tensors["network." + parameter.key()] = ToModelTensor(parameter.value());
    if (this->IsOfMuon(parameter.value()))
    {
      checkpoint.Tensors["momentum." + parameter.key()] = ToModelTensor(this->Matrices->MomentumOf(parameter.value()));
    }
  }
  checkpoint.Tensors["average.all"] = ToModelTensor(this->Average);
  const AdamMoments moments = GetMoments(*this->Adam, this->Weights->Values());
  if (moments.Mean.defined())
  {
    checkpoint.Tensors["adam_mean.all"] = ToModelTensor(moments.Mean);
    checkpoint.Tensors["adam_square.all"] = ToModelTensor(moments.Square);
  }
  return checkpoint;
}

void LatentDiffusionTrainer::Internals::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  const torch::NoGradGuard noGradients;
  // All that can fail comes first, so that a training is not left half restored.
  std::vector<torch::Tensor> values;
  std::vector<torch::Tensor> momenta; // undefined but for those of Muon
  for (const auto& parameter : this->Network->named_parameters())
  {
    const torch::Tensor& value = parameter.value();
    values.push_back(ReadTensor(file, checkpoint, "network." + parameter.key(), value));
    momenta.push_back(
      this->IsOfMuon(value) ? ReadTensor(file, checkpoint, "momentum." + parameter.key(), value) : torch::Tensor());
  }
  const torch::Tensor average = ReadTensor(file, checkpoint, "average.all", this->Average);
  const auto rows = static_cast<std::int64_t>(checkpoint.History.Size());
  const ModelTensor byTime = ToModelTensor(ReadTensor(
    file, checkpoint, TimeLossesName, torch::empty({ rows, static_cast<std::int64_t>(NumberOfTimeLosses) })));
  AdamMoments moments;
  if (rows > 0)
  {
    moments = ReadMoments(file, checkpoint, "all", this->Weights->Values());
  }
  LossHistory history = DiffusionLossHistory();
  for (std::int64_t k = 0; k < rows; ++k)
  {
    const std::vector<double>& from = checkpoint.History.Row(static_cast<std::size_t>(k));
    std::vector<double> row = { from[0], from[1], from[4], from[5] };
    AppendTimeRow(byTime, static_cast<std::size_t>(k), row);
    history.Append(row);
  }
  this->History = history;
  this->Average.copy_(average);
  const std::vector<torch::Tensor> parameters = this->Network->parameters();
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    torch::Tensor parameter = parameters[k];
    parameter.copy_(values[k]);
    if (momenta[k].defined())
    {
      this->Matrices->SetMomentum(parameter, momenta[k]);
    }
  }
  if (moments.Mean.defined())
  {
    SetMoments(*this->Adam, this->Weights->Values(), moments, this->Done());
  }
}

LatentDiffusionModel LatentDiffusionTrainer::Internals::Model()
{
  LatentDiffusionModel model;
  model.Options = this->Options.Network;
  model.Iterations = this->Done();
  model.Autoencoder = this->Autoencoder;
  model.TrainingPoints = this->Vertices / static_cast<std::int64_t>(this->Surfaces.size());
  model.Tensors["latent_scale"] = { { this->Options.Network.LatentDimension }, this->Scale };
  std::int64_t first = 0;
  for (const auto& parameter : this->Network->named_parameters())
  {
    const torch::Tensor& value = parameter.value();
    model.Tensors[parameter.key()] = ToModelTensor(this->Average.narrow(0, first, value.numel()).view(value.sizes()));
    first += value.numel();
  }
  return model;
}

LatentDiffusionTrainer::LatentDiffusionTrainer(LatentDataset dataset, const LatentDiffusionTrainingOptions& options)
{
  CheckDataset(dataset);
  LatentDiffusionTrainingOptions complete = options;
  complete.Network.LatentDimension = dataset.Dimension();
  complete.Network.NumberOfLabels = dataset.NumberOfLabels();
  complete.Network.Directed = dataset.IsDirected();
  CheckOptions(complete);
  for (LatentSurface& surface : dataset.Surfaces)
  {
    // Labels of -1 alone are none.
    surface.Labels = complete.Network.NumberOfLabels == 0 ? std::vector<std::int32_t>() : surface.Labels;
  }
  this->Impl = std::make_unique<Internals>(dataset, complete);
}

LatentDiffusionTrainer::~LatentDiffusionTrainer() = default;
LatentDiffusionTrainer::LatentDiffusionTrainer(LatentDiffusionTrainer&&) noexcept = default;
LatentDiffusionTrainer& LatentDiffusionTrainer::operator=(LatentDiffusionTrainer&&) noexcept = default;

void LatentDiffusionTrainer::Step() { this->Impl->Step(); }

std::int64_t LatentDiffusionTrainer::Iterations() const { return this->Impl->Options.Iterations; }

const LossHistory& LatentDiffusionTrainer::History() const { return this->Impl->History; }

const LatentDiffusionTrainingOptions& LatentDiffusionTrainer::Options() const { return this->Impl->Options; }

std::string LatentDiffusionTrainer::DeviceName() const { return NameOf(this->Impl->Device()); }

std::map<std::string, std::string> LatentDiffusionTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint LatentDiffusionTrainer::Checkpoint() const { return this->Impl->Checkpoint(); }

void LatentDiffusionTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Restore(file, checkpoint);
}

void LatentDiffusionTrainer::SaveModel(const std::string& path) const { WriteLatentDiffusion(path, this->Model()); }

LatentDiffusionModel LatentDiffusionTrainer::Model() const { return this->Impl->Model(); }

LatentDiffusionTrainer TrainLatentDiffusion(LatentDataset dataset, const LatentDiffusionTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  LatentDiffusionTrainer trainer(std::move(dataset), options);
  TrainAndSave(trainer, files, observe, progress);
  return trainer;
}

} // namespace surfsynth
