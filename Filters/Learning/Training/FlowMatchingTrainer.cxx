// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FlowMatchingTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Learning/Layers/MeshTensors.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/SampleGradients.h"
#include "Learning/Training/SourceOperators.h"
#include "Learning/Training/TrainingCheckpoint.h"
#include "Learning/Training/TrainingSources.h"

#include <torch/torch.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr double BytesOfMiB = 1048576.0;
/// Samples of each surface that the size of gradients is measured on.
constexpr std::int64_t SamplesMeasured = 100;
/// Largest weight of the squared error of predicted data; that of the velocity has 1 / (1 - t)^2. With 5 the end of the flow is
/// learnt less precisely, with 300 its middle.
constexpr double MaximumDataWeight = 30.0;

/// The network that the training begins with.
PoissonNetModel InitialVelocity(const FlowMatchingTrainingOptions& options, const TrainingSources& sources)
{
  if (options.InitialModel)
  {
    return options.InitialModel->Velocity;
  }
  PoissonNetOptions network = NetworkOfSize(options);
  network.InputChannels = network.OutputChannels = sources.Components;
  network.ExtraFeatures = 1 + sources.Sources.front().Condition.cols();
  network.Head = sources.Frame.GeneratesPositions() ? PoissonNetHead::GradientDomain : PoissonNetHead::Linear;
  return InitialPoissonNet(network, options.Seed);
}

/// Distinguishes encoders whose results have the same number of channels.
std::string Identity(const PoissonNetModel& model)
{
  std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a, over 32-bit words
  for (const auto& entry : model.Tensors)
  {
    for (const float value : entry.second.Values)
    {
      std::uint32_t word;
      std::memcpy(&word, &value, sizeof word);
      hash = (hash ^ word) * 0x100000001b3;
    }
  }
  return std::to_string(model.Options.ResultChannels()) + " channels, " + std::to_string(hash);
}

/// Inputs and targets of the network in one iteration on one surface.
struct Batch
{
  torch::Tensor Times;     ///< [B], on the processor
  torch::Tensor Input;     ///< u of FlowPrediction, [B, V, C]
  torch::Tensor Condition; ///< [B, V, 4 + E]
  torch::Tensor Target;    ///< of the network's output, [B, V, C]
  torch::Tensor Factors;   ///< of the squared error of the output, which make it that of the velocity in its units, [B]
  torch::Tensor Weights;   ///< of the loss of the velocity, [B]

  /// The batch of sample @p k alone.
  Batch Sample(std::int64_t k) const
  {
    const auto part = [&](const torch::Tensor& tensor) { return tensor.narrow(0, k, 1); };
    return { part(this->Times), part(this->Input), part(this->Condition), part(this->Target), part(this->Factors),
      part(this->Weights) };
  }
};

/// Losses of samples in velocities, [B] each.
struct SampleLosses
{
  torch::Tensor Vertex;
  torch::Tensor Jacobian;
  torch::Tensor Sum; ///< by the weights of the recipe
};

/// The losses of several batches as those of one.
SampleLosses Joined(const std::vector<SampleLosses>& batches)
{
  std::vector<torch::Tensor> parts[3];
  for (const SampleLosses& losses : batches)
  {
    parts[0].push_back(losses.Vertex);
    parts[1].push_back(losses.Jacobian);
    parts[2].push_back(losses.Sum);
  }
  return { torch::cat(parts[0]), torch::cat(parts[1]), torch::cat(parts[2]) };
}

/// Sorts the losses of samples into the parts of the time.
void AddByTime(const torch::Tensor& times, const torch::Tensor& losses, TimeLosses& sorted)
{
  const torch::Tensor values = losses.detach().to(torch::kCPU, torch::kFloat64).contiguous();
  for (std::int64_t k = 0; k < values.numel(); ++k)
  {
    const auto part = static_cast<std::size_t>(times.data_ptr<float>()[k] * static_cast<float>(NumberOfTimeLosses));
    sorted[std::min(part, NumberOfTimeLosses - 1)].push_back(values.data_ptr<double>()[k]);
  }
}
} // namespace

class FlowMatchingTrainer::Internals
{
public:
  Internals(SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress)
    : Options(options)
    , DatasetHash(ContentHash(dataset))
    , Device(ChooseDevice(options.Device))
    , Operators(options.SourceMemory * BytesOfMiB, [this](std::size_t number) { return this->BuildOperators(number); })
    , Data(this->Prepare(std::move(dataset), progress))
    , Training(InitialVelocity(options, this->Data), options, "loss_")
  {
    if (!options.InitialModel)
    {
      this->Data.Frame.Prediction = options.Prediction.value_or(
        DefaultPrediction(this->Data.Frame.GeneratesPositions()));
    }
    for (TrainingSource& source : this->Data.Sources)
    {
      this->Conditions.push_back(ToTensor(source.Condition, this->Device));
      source.Condition.resize(0, 0); // on the device from now on
    }
    if (this->Data.Frame.Prediction != FlowPrediction::Velocity)
    {
      const double squares = this->GradientSquares();
      this->JacobianFactor = squares > 0.0 ? 1.0 / squares : 1.0;
    }
  }

  void Accumulate(NetworkLosses& losses);
  std::map<std::string, std::string> Recipe() const;

  FlowMatchingTrainingOptions Options;
  std::uint64_t DatasetHash;
  torch::Device Device;
  SourceCache Operators;
  TrainingSources Data;
  NetworkTraining Training;

private:
  TrainingSources Prepare(SignalDataset dataset, const Progress& progress);
  SourceOperators BuildOperators(std::size_t number) const;
  NormalKey KeyOf(std::int64_t slot) const;
  double GradientSquares();
  SampleLosses LossesOf(const MeshTensors& mesh, const Batch& batch);
  SampleLosses AddGradients(const MeshTensors& mesh, const Batch& batch, double share);
  Batch MakeBatch(std::size_t number, const SourceOperators& operators, std::int64_t first, std::int64_t count) const;
  void SetTargets(Batch& batch, const torch::Tensor& start, const torch::Tensor& end, const torch::Tensor& time,
    const torch::Tensor& condition) const;

  std::vector<torch::Tensor> Conditions; ///< of the sources, on the device
  /// Over the mean square of the gradients of the data, in units of DataDeviation; 1 where velocities are predicted.
  double JacobianFactor = 1.0;
};

/// Prepares the sources and keeps as many of their operators as fit.
TrainingSources FlowMatchingTrainer::Internals::Prepare(SignalDataset dataset, const Progress& progress)
{
  const FlowMatchingTrainingOptions& options = this->Options;
  const auto keep = [&](std::size_t number, const TrainingSource& source, SourceFactors factors) {
    this->Operators.Offer(number, SourceOperators(source.Mesh, std::move(factors), this->Device));
  };
  return PrepareSources(std::move(dataset), options.InitialModel ? &*options.InitialModel : nullptr,
    options.Encoder ? &*options.Encoder : nullptr, options.WithoutEncoder, options.Noise, options.Seed, keep, progress);
}

/// The operators of a source, with the bits of those of its preparation.
SourceOperators FlowMatchingTrainer::Internals::BuildOperators(std::size_t number) const
{
  const TriangleMesh& mesh = this->Data.Sources[number].Mesh;
  return SourceOperators(mesh, BuildFactors(mesh, this->Data.Frame.Noise), this->Device);
}

/// Values that must be the same when a training goes on.
std::map<std::string, std::string> FlowMatchingTrainer::Internals::Recipe() const
{
  std::map<std::string, std::string> recipe = RecipeOf(this->Options, "flow_matching");
  recipe["noise"] = std::to_string(static_cast<int>(this->Options.Noise.Model));
  recipe["noise_screening"] = FormatExact(this->Options.Noise.Screening);
  recipe["noise_eigenpairs"] = std::to_string(this->Options.Noise.Eigenpairs);
  recipe["noise_smoothing"] = FormatExact(this->Options.Noise.Smoothing);
  recipe["noise_scale"] = FormatExact(this->Options.Noise.Scale);
  recipe["encoder"] = this->Options.Encoder ? Identity(*this->Options.Encoder) : "none";
  recipe["signal"] = this->Data.Frame.SignalName;
  // Recipes of earlier versions have no such entries.
  if (this->Data.Frame.Prediction != FlowPrediction::Velocity)
  {
    recipe["prediction"] = NameOf(this->Data.Frame.Prediction);
  }
  if (this->Options.InitialModel)
  {
    recipe["initial_model"] = Identity(this->Options.InitialModel->Velocity);
  }
  else if (this->Data.Sources.size() > 1)
  {
    recipe["noise_fit"] = "all sources";
  }
  recipe["batch_size"] = std::to_string(this->Options.BatchSize);
  recipe["sources_per_batch"] = std::to_string(this->Options.SourcesPerBatch);
  recipe["vertex_weight"] = FormatExact(this->Options.VertexWeight);
  recipe["jacobian_weight"] = FormatExact(this->Options.JacobianWeight);
  recipe["dataset"] = std::to_string(this->DatasetHash);
  return recipe;
}

/// Random numbers of one slot of this iteration's batch.
NormalKey FlowMatchingTrainer::Internals::KeyOf(std::int64_t slot) const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Sample = static_cast<std::uint32_t>(this->Training.Iteration());
  key.Component = static_cast<std::uint32_t>(slot);
  return key;
}

/// Mean square of the gradients of the data over their deviation, as the loss measures it, of the first samples of each
/// surface.
double FlowMatchingTrainer::Internals::GradientSquares()
{
  const torch::NoGradGuard noGradients;
  const bool positions = this->Data.Frame.GeneratesPositions();
  double squares = 0.0;
  for (std::size_t k = 0; k < this->Data.Sources.size(); ++k)
  {
    const TrainingSource& source = this->Data.Sources[k];
    const std::int64_t count = std::min<std::int64_t>(source.Samples.rows(), SamplesMeasured);
    const torch::Tensor samples = torch::from_blob(const_cast<float*>(source.Samples.data()),
      { count, source.NumberOfPoints(), this->Data.Components }, torch::kFloat32)
                                    .to(this->Device);
    const torch::Tensor data = positions ? samples - this->Conditions[k].slice(-1, 0, 3) : samples;
    const PoissonNetOutput nothing = { torch::zeros_like(data), {} };
    const FlowMatchingLoss loss = ComputeFlowMatchingLoss(
      this->Operators.Get(k).Mesh, nothing, data / this->Data.Frame.DataDeviation);
    squares += loss.Jacobian.mean().item<double>() / static_cast<double>(this->Data.Sources.size());
  }
  return squares;
}

/// Slots @p first to @p first + @p count of the batch of this iteration, all on one surface.
Batch FlowMatchingTrainer::Internals::MakeBatch(
  std::size_t number, const SourceOperators& operators, std::int64_t first, std::int64_t count) const
{
  const TrainingSource& source = this->Data.Sources[number];
  const std::int64_t vertices = source.NumberOfPoints();
  const std::int64_t components = this->Data.Components;
  const torch::Tensor samples = torch::empty({ count, vertices, components }, torch::kFloat32);
  const torch::Tensor noise = torch::empty({ count, vertices, components }, torch::kFloat64);
  const torch::Tensor times = torch::empty({ count, 1, 1 }, torch::kFloat32);
  for (std::int64_t slot = 0; slot < count; ++slot)
  {
    const NormalKey key = this->KeyOf(first + slot);
    const std::int64_t sample = UniformIndex(key, 1, source.Samples.rows());
    times.data_ptr<float>()[slot] = static_cast<float>(Uniform(key, 2));
    std::copy_n(source.Samples.row(sample).data(), vertices * components,
      samples.data_ptr<float>() + slot * vertices * components);
  }
  SampleRequest request;
  request.Seed = this->Options.Seed;
  request.FirstSample = static_cast<std::uint32_t>(this->Training.Iteration() * this->Options.BatchSize + first);
  request.NumberOfSamples = static_cast<std::uint32_t>(count);
  request.NumberOfComponents = static_cast<std::uint32_t>(components);
  request.Scale = this->Data.Frame.Noise.Scale;
  operators.Noise->SampleInto(request, [&](std::uint32_t sample) {
    return noise.data_ptr<double>() + (sample - request.FirstSample) * vertices * components;
  });

  torch::Tensor start = noise.to(this->Device, torch::kFloat32);
  if (this->Data.Frame.GeneratesPositions())
  {
    start = start - MassMean(operators.Mesh, start);
  }
  const torch::Tensor end = samples.to(this->Device);
  const torch::Tensor time = times.to(this->Device);
  const torch::Tensor& condition = this->Conditions[number];
  Batch batch;
  batch.Times = times.view({ count });
  batch.Condition = torch::cat({ time.expand({ count, vertices, 1 }), condition.expand({ count, -1, -1 }) }, -1);
  this->SetTargets(batch, start, end, time, condition);
  return batch;
}

/// What the network sees at @p time, [B, 1, 1], between @p start and @p end, and what it is to predict.
void FlowMatchingTrainer::Internals::SetTargets(Batch& batch, const torch::Tensor& start, const torch::Tensor& end,
  const torch::Tensor& time, const torch::Tensor& condition) const
{
  if (this->Data.Frame.Prediction == FlowPrediction::Velocity)
  {
    batch.Input = (1.0 - time) * start + time * end;
    batch.Target = end - start;
    batch.Factors = batch.Weights = torch::ones({ time.size(0) }, end.options());
    return;
  }
  const double deviation = this->Data.Frame.DataDeviation;
  const torch::Tensor data = this->Data.Frame.GeneratesPositions() ? end - condition.slice(-1, 0, 3) : end;
  const torch::Tensor squares = (1.0 - time).square() + time.square();
  batch.Input = ((1.0 - time) * start + time * data) / (deviation * squares.sqrt());
  if (this->Data.Frame.Prediction == FlowPrediction::Preconditioned)
  {
    batch.Target = ((1.0 - time) * data - time * start) / (deviation * squares.sqrt());
    batch.Factors = squares.reciprocal().flatten(); // in units of the deviation
    batch.Weights = torch::ones({ time.size(0) }, end.options());
  }
  else
  {
    const torch::Tensor remaining = (1.0 - time).clamp_min(RemainingTime(1.0));
    batch.Target = data / deviation;
    batch.Factors = remaining.square().reciprocal().flatten();
    batch.Weights = (MaximumDataWeight * remaining.square()).clamp_max(1.0).flatten();
  }
  if (this->Data.Frame.GeneratesPositions()) // whose head adds its input
  {
    batch.Target = batch.Target + batch.Input;
  }
}

/// Losses of the network on a batch.
SampleLosses FlowMatchingTrainer::Internals::LossesOf(const MeshTensors& mesh, const Batch& batch)
{
  const FlowMatchingLoss loss = ComputeFlowMatchingLoss(
    mesh, this->Training.Network().forward(mesh, batch.Input, batch.Condition), batch.Target);
  SampleLosses losses = { loss.Vertex * batch.Factors, loss.Jacobian * batch.Factors * this->JacobianFactor, {} };
  losses.Sum = this->Options.VertexWeight * losses.Vertex + this->Options.JacobianWeight * losses.Jacobian;
  return losses;
}

/// Adds the gradient of the mean loss of a batch, times @p share, to that of the parameters. Samples of networks with dropout,
/// whose random numbers come from a sequence, stay together.
SampleLosses FlowMatchingTrainer::Internals::AddGradients(const MeshTensors& mesh, const Batch& batch, double share)
{
  PoissonNetImpl& network = this->Training.Network();
  const std::int64_t size = batch.Times.size(0);
  if (network.Options().Dropout > 0.0 || !ServesSampleGradients(this->Device, size))
  {
    const SampleLosses losses = this->LossesOf(mesh, batch);
    ((losses.Sum * batch.Weights).mean() * share).backward();
    return losses;
  }
  std::vector<SampleLosses> losses(static_cast<std::size_t>(size));
  AddSampleGradients(network.parameters(), size, [&](std::int64_t k) {
    const Batch sample = batch.Sample(k);
    const SampleLosses own = this->LossesOf(mesh, sample);
    losses[static_cast<std::size_t>(k)] = { own.Vertex.detach(), own.Jacobian.detach(), own.Sum.detach() };
    return (own.Sum * sample.Weights).sum() * (share / static_cast<double>(size));
  });
  return Joined(losses);
}

/// The loss of this iteration and its gradient, which is added to that of the parameters. Groups follow one another in the
/// order of their numbers, whatever is kept of the sources, so that sums have the same bits.
void FlowMatchingTrainer::Internals::Accumulate(NetworkLosses& losses)
{
  const std::int64_t groups = this->Options.SourcesPerBatch;
  const std::int64_t size = this->Options.BatchSize / groups;
  const auto share = 1.0 / static_cast<double>(groups);
  for (std::int64_t group = 0; group < groups; ++group)
  {
    const auto source = static_cast<std::size_t>(
      UniformIndex(this->KeyOf(group), 0, static_cast<std::int64_t>(this->Data.Sources.size())));
    const SourceOperators& operators = this->Operators.Get(source);
    const Batch batch = this->MakeBatch(source, operators, group * size, size);
    const SampleLosses own = this->AddGradients(operators.Mesh, batch, share);
    losses.Vertex += share * own.Vertex.mean().item<double>();
    losses.Jacobian += share * own.Jacobian.mean().item<double>();
    AddByTime(batch.Times, own.Sum, losses.ByTime);
  }
  losses.Total = this->Options.VertexWeight * losses.Vertex + this->Options.JacobianWeight * losses.Jacobian;
}

double DefaultSmoothing(bool positions) { return positions ? 0.0 : 1.0; }

FlowPrediction DefaultPrediction(bool positions)
{
  return positions ? FlowPrediction::Data : FlowPrediction::Preconditioned;
}

void CheckOptions(const FlowMatchingTrainingOptions& options)
{
  CheckOptions(static_cast<const TrainingOptions&>(options));
  const OptionChecks check("TrainingOptions");
  check.Count("BatchSize", options.BatchSize, 1, 100000);
  check.Require(options.SourcesPerBatch >= 1 && options.BatchSize % options.SourcesPerBatch == 0, "SourcesPerBatch",
    std::to_string(options.SourcesPerBatch), "a number that divides BatchSize");
  check.Require(options.Iterations * options.BatchSize < (std::int64_t(1) << 32), "Iterations * BatchSize",
    static_cast<double>(options.Iterations) * static_cast<double>(options.BatchSize), "below 2^32");
  check.Weight("SourceMemory", options.SourceMemory);
  check.Weight("VertexWeight", options.VertexWeight);
  check.Weight("JacobianWeight", options.JacobianWeight);
  check.Require(options.VertexWeight + options.JacobianWeight > 0.0, "VertexWeight + JacobianWeight", 0.0,
    "a number above 0: else nothing is learnt");
  const bool replaces = options.InitialModel && options.Encoder;
  check.Require(!replaces ||
      (options.InitialModel->Encoder &&
        options.InitialModel->Encoder->Options.OutputChannels == options.Encoder->Options.OutputChannels),
    "Encoder", "given with InitialModel", "none, or one with as many channels as the encoder of that model");
  check.Require(!options.WithoutEncoder || !options.Encoder, "WithoutEncoder", "given with Encoder", "one of both");
  check.Positive("Noise.Screening", options.Noise.Screening);
  check.Weight("Noise.Scale", options.Noise.Scale);
  if (options.Noise.Smoothing != ChosenSmoothing)
  {
    check.Weight("Noise.Smoothing", options.Noise.Smoothing);
  }
  check.Count("Noise.Eigenpairs", options.Noise.Eigenpairs, 1, 1000000);
}

FlowMatchingTrainer::FlowMatchingTrainer(
  SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress)
{
  CheckOptions(options);
  this->Impl = std::make_unique<Internals>(std::move(dataset), options, progress);
}

FlowMatchingTrainer::~FlowMatchingTrainer() = default;
FlowMatchingTrainer::FlowMatchingTrainer(FlowMatchingTrainer&&) noexcept = default;
FlowMatchingTrainer& FlowMatchingTrainer::operator=(FlowMatchingTrainer&&) noexcept = default;

void FlowMatchingTrainer::Step()
{
  this->Impl->Training.Step([this](NetworkLosses& losses) { this->Impl->Accumulate(losses); });
}

std::int64_t FlowMatchingTrainer::Iterations() const { return this->Impl->Options.Iterations; }

const LossHistory& FlowMatchingTrainer::History() const { return this->Impl->Training.History(); }

const FlowMatchingTrainingOptions& FlowMatchingTrainer::Options() const { return this->Impl->Options; }

std::string FlowMatchingTrainer::DeviceName() const { return NameOf(this->Impl->Device); }

const SourceMemoryUse& FlowMatchingTrainer::SourceMemory() const { return this->Impl->Operators.Use(); }

std::map<std::string, std::string> FlowMatchingTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint FlowMatchingTrainer::Checkpoint() const { return this->Impl->Training.Checkpoint(); }

void FlowMatchingTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Training.Restore(file, checkpoint);
}

void FlowMatchingTrainer::SaveModel(const std::string& path) const { WriteFlowMatchingModel(path, this->Model()); }

FlowMatchingModel FlowMatchingTrainer::Model() const
{
  FlowMatchingModel model = this->Impl->Data.Frame;
  model.Iterations = this->Iteration();
  model.Velocity = this->Impl->Training.Model();
  model.Velocity.Normalization = InputNormalization::SurfaceArea;
  return model;
}

FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  FlowMatchingTrainer trainer(std::move(dataset), options, SubProgress(progress, 0.0, 0.02));
  TrainAndSave(trainer, files, observe, SubProgress(progress, 0.02, 1.0));
  return trainer;
}

} // namespace surfsynth
