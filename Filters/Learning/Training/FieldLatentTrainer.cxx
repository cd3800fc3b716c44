// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FieldLatentTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterNormals.h"
#include "Learning/Losses/FieldLatentLosses.h"
#include "Learning/Networks/FieldLatentNetworks.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/FlatParameters.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/TextureRings.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::uint32_t LatentStream = 9; ///< of random numbers; TextureRings has streams of its own

LossHistory FieldLatentLossHistory()
{
  return { { "iteration" }, { "loss", "reconstruction_loss", "divergence_loss", "gradient_norm", "learning_rate" },
    "loss" };
}

/// The same rows under other names of the columns.
LossHistory WithRowsOf(LossHistory columns, const LossHistory& history)
{
  for (std::size_t k = 0; k < history.Size(); ++k)
  {
    columns.Append(history.Row(k));
  }
  return columns;
}

/// The first whole rows of @p values, on @p device.
torch::Tensor TensorOf(const std::vector<float>& values, std::vector<std::int64_t> shape, const torch::Device& device)
{
  return torch::from_blob(const_cast<float*>(values.data()), shape, torch::kFloat32)
    .to(device, torch::kFloat32, false, true);
}

/// Losses of one iteration.
struct FieldLatentLosses
{
  torch::Tensor Reconstruction;
  torch::Tensor Divergence;
};
} // namespace

void CheckOptions(const FieldLatentTrainingOptions& options)
{
  CheckOptions(options.Network);
  const OptionChecks check("FieldLatentTrainingOptions");
  check.Iterations("Iterations", options.Iterations);
  check.Count("BatchSize", options.BatchSize, 1, 1000000);
  check.Require(options.Network.Coordinates == FieldLatentCoordinates::Logarithmic || options.BatchSize % 3 == 0,
    "BatchSize", std::to_string(options.BatchSize), "a multiple of 3 with barycentric coordinates");
  check.LearningRate("LearningRate", options.LearningRate);
  check.LearningRate("FinalLearningRate", options.FinalLearningRate);
  check.Weight("DivergenceWeight", options.DivergenceWeight);
  check.Positive("MinimumTexels", options.MinimumTexels);
  check.Positive("MaximumTexels", options.MaximumTexels);
  check.Require(
    options.MaximumTexels >= options.MinimumTexels, "MaximumTexels", options.MaximumTexels, "at least MinimumTexels");
  check.Weight("TargetPower", options.TargetPower);
  check.Require(options.ColorAugmentation >= 0.0 && options.ColorAugmentation <= 1.0, "ColorAugmentation",
    options.ColorAugmentation, "0 to 1");
  check.Weight("GradientClip", options.GradientClip);
}

class FieldLatentTrainer::Internals
{
public:
  Internals(TextureDataset dataset, const FieldLatentTrainingOptions& options)
    : Options(options)
    , Rings(std::move(dataset), options.Network.Coordinates == FieldLatentCoordinates::Barycentric)
    , Where(ChooseDevice(options.Device))
    , Network(MakeFieldLatentNetwork(InitialFieldLatents(options.Network, options.Seed)))
  {
    this->Network->to(this->Where);
    this->Weights = std::make_unique<FlatParameters>(*this->Network);
    this->Adam = std::make_unique<torch::optim::Adam>(
      std::vector<torch::Tensor>{ this->Weights->Values() }, torch::optim::AdamOptions(options.LearningRate));
  }

  void Step();
  std::map<std::string, std::string> Recipe() const;
  TrainingCheckpoint Checkpoint();
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint);
  FieldLatentModel Model();
  std::int64_t Done() const { return static_cast<std::int64_t>(this->History.Size()); }

  FieldLatentTrainingOptions Options;
  TextureRings Rings;
  torch::Device Where;
  LossHistory History = FieldLatentLossHistory();

private:
  double LearningRate() const;
  torch::Tensor LatentNoise() const;
  FieldLatentLosses Losses();

  FieldLatentNetwork Network;
  std::unique_ptr<FlatParameters> Weights;
  std::unique_ptr<torch::optim::Adam> Adam;
};

double FieldLatentTrainer::Internals::LearningRate() const
{
  constexpr double pi = 3.14159265358979323846;
  const double part = static_cast<double>(this->Done()) / static_cast<double>(this->Options.Iterations);
  return this->Options.FinalLearningRate +
    0.5 * (this->Options.LearningRate - this->Options.FinalLearningRate) * (1.0 + std::cos(pi * std::min(part, 1.0)));
}

/// Standard normal numbers of this iteration, [R, d, 2].
torch::Tensor FieldLatentTrainer::Internals::LatentNoise() const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = LatentStream;
  key.Sample = static_cast<std::uint32_t>(this->Done());
  const torch::Tensor noise = torch::empty(
    { this->Options.BatchSize, this->Options.Network.LatentDimension, 2 }, torch::kFloat64);
  FillNormals(key, 0, noise.numel(), noise.data_ptr<double>());
  return noise.to(this->Where, torch::kFloat32);
}

/// The losses of this iteration.
FieldLatentLosses FieldLatentTrainer::Internals::Losses()
{
  const FieldLatentOptions& network = this->Options.Network;
  TextureRingSizes sizes;
  sizes.Rings = this->Options.BatchSize;
  sizes.Samples = network.SamplesPerRing;
  sizes.MinimumTexels = this->Options.MinimumTexels;
  sizes.MaximumTexels = this->Options.MaximumTexels;
  sizes.TargetPower = this->Options.TargetPower;
  sizes.ColorAugmentation = this->Options.ColorAugmentation;
  sizes.InTriangles = network.Coordinates == FieldLatentCoordinates::Barycentric;
  const TextureRingBatch batch = this->Rings.Draw(sizes, this->Options.Seed, this->Done());
  const auto tensor = [&](const std::vector<float>& values, std::int64_t columns, bool triangles) {
    return triangles ? TensorOf(values, { sizes.Rings / 3, 3 * sizes.Samples, columns }, this->Where)
                     : TensorOf(values, { sizes.Rings, sizes.Samples, columns }, this->Where);
  };
  const FieldLatentGaussians gaussians = this->Network->Encoder(
    tensor(batch.Logarithms, 2, false), tensor(batch.Colors, 3, false));
  const torch::Tensor latents = SampleLatents(gaussians, this->LatentNoise());
  const torch::Tensor predicted = sizes.InTriangles
    ? this->Network->Decoder->Blended(
        latents.view({ sizes.Rings / 3, 3, network.LatentDimension, 2 }), tensor(batch.Barycentric, 3, true))
    : this->Network->Decoder(latents, tensor(batch.TargetLogarithms, 2, false));
  return { ColorLoss(predicted, tensor(batch.TargetColors, 3, sizes.InTriangles)), KullbackLeiblerLoss(gaussians) };
}

void FieldLatentTrainer::Internals::Step()
{
  const std::int64_t iteration = this->Done() + 1;
  const double learningRate = this->LearningRate();
  this->Weights->ZeroGradients();
  const FieldLatentLosses losses = this->Losses();
  const torch::Tensor total = losses.Reconstruction + this->Options.DivergenceWeight * losses.Divergence;
  total.backward();
  const double loss = total.item<double>();
  const double gradientNorm = this->Weights->ClipGradients(this->Options.GradientClip);
  if (!std::isfinite(loss) || !std::isfinite(gradientNorm))
  {
    throw SolverFailure("The loss or its gradient is not finite in iteration " + std::to_string(iteration) +
      " of the training; expected a lower learning rate.");
  }
  static_cast<torch::optim::AdamOptions&>(this->Adam->param_groups()[0].options()).lr(learningRate);
  this->Adam->step();
  RequireFiniteWeights({ this->Weights->Values() }, iteration);
  this->History.Append({ static_cast<double>(iteration), loss, losses.Reconstruction.item<double>(),
    losses.Divergence.item<double>(), gradientNorm, learningRate });
}

std::map<std::string, std::string> FieldLatentTrainer::Internals::Recipe() const
{
  const FieldLatentTrainingOptions& o = this->Options;
  return { { "training", "field_latents" }, { "latent_dimension", std::to_string(o.Network.LatentDimension) },
    { "channels", std::to_string(o.Network.Channels) }, { "encoder_layers", std::to_string(o.Network.EncoderLayers) },
    { "heads", std::to_string(o.Network.Heads) }, { "samples_per_ring", std::to_string(o.Network.SamplesPerRing) },
    { "decoder_layers", std::to_string(o.Network.DecoderLayers) },
    { "decoder_width", std::to_string(o.Network.DecoderWidth) }, { "coordinates", NameOf(o.Network.Coordinates) },
    { "batch_size", std::to_string(o.BatchSize) }, { "learning_rate", FormatExact(o.LearningRate) },
    { "final_learning_rate", FormatExact(o.FinalLearningRate) },
    { "divergence_weight", FormatExact(o.DivergenceWeight) }, { "minimum_texels", FormatExact(o.MinimumTexels) },
    { "maximum_texels", FormatExact(o.MaximumTexels) }, { "target_power", FormatExact(o.TargetPower) },
    { "color_augmentation", FormatExact(o.ColorAugmentation) }, { "gradient_clip", FormatExact(o.GradientClip) },
    { "seed", std::to_string(o.Seed) }, { "dataset", std::to_string(this->Rings.Hash()) } };
}

TrainingCheckpoint FieldLatentTrainer::Internals::Checkpoint()
{
  TrainingCheckpoint checkpoint;
  checkpoint.History = WithRowsOf(NetworkLossHistory(), this->History); // checkpoints have columns of the same names
  for (const auto& parameter : this->Network->named_parameters())
  {
    checkpoint.Tensors["network." + parameter.key()] = ToModelTensor(parameter.value());
  }
  const AdamMoments moments = GetMoments(*this->Adam, this->Weights->Values());
  if (moments.Mean.defined())
  {
    checkpoint.Tensors["adam_mean.all"] = ToModelTensor(moments.Mean);
    checkpoint.Tensors["adam_square.all"] = ToModelTensor(moments.Square);
  }
  return checkpoint;
}

void FieldLatentTrainer::Internals::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  const torch::NoGradGuard noGradients;
  // All that can fail comes first, so that a training is not left half restored.
  std::vector<torch::Tensor> values;
  for (const auto& parameter : this->Network->named_parameters())
  {
    values.push_back(ReadTensor(file, checkpoint, "network." + parameter.key(), parameter.value()));
  }
  AdamMoments moments;
  if (!checkpoint.History.IsEmpty())
  {
    moments = ReadMoments(file, checkpoint, "all", this->Weights->Values());
  }
  this->History = WithRowsOf(FieldLatentLossHistory(), checkpoint.History);
  const std::vector<torch::Tensor> parameters = this->Network->parameters();
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    torch::Tensor parameter = parameters[k];
    parameter.copy_(values[k]);
  }
  if (moments.Mean.defined())
  {
    SetMoments(*this->Adam, this->Weights->Values(), moments, this->Done());
  }
}

FieldLatentModel FieldLatentTrainer::Internals::Model()
{
  FieldLatentModel model;
  model.Options = this->Options.Network;
  model.Iterations = this->Done();
  for (const auto& parameter : this->Network->named_parameters())
  {
    model.Tensors[parameter.key()] = ToModelTensor(parameter.value());
  }
  return model;
}

FieldLatentTrainer::FieldLatentTrainer(TextureDataset dataset, const FieldLatentTrainingOptions& options)
{
  CheckOptions(options);
  this->Impl = std::make_unique<Internals>(std::move(dataset), options);
}

FieldLatentTrainer::~FieldLatentTrainer() = default;
FieldLatentTrainer::FieldLatentTrainer(FieldLatentTrainer&&) noexcept = default;
FieldLatentTrainer& FieldLatentTrainer::operator=(FieldLatentTrainer&&) noexcept = default;

void FieldLatentTrainer::Step() { this->Impl->Step(); }

std::int64_t FieldLatentTrainer::Iterations() const { return this->Impl->Options.Iterations; }

const LossHistory& FieldLatentTrainer::History() const { return this->Impl->History; }

const FieldLatentTrainingOptions& FieldLatentTrainer::Options() const { return this->Impl->Options; }

std::string FieldLatentTrainer::DeviceName() const { return NameOf(this->Impl->Where); }

std::map<std::string, std::string> FieldLatentTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint FieldLatentTrainer::Checkpoint() const { return this->Impl->Checkpoint(); }

void FieldLatentTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Restore(file, checkpoint);
}

void FieldLatentTrainer::SaveModel(const std::string& path) const { WriteFieldLatents(path, this->Model()); }

FieldLatentModel FieldLatentTrainer::Model() const { return this->Impl->Model(); }

FieldLatentTrainer TrainFieldLatents(TextureDataset dataset, const FieldLatentTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  FieldLatentTrainer trainer(std::move(dataset), options);
  TrainAndSave(trainer, files, observe, progress);
  return trainer;
}

} // namespace surfsynth
