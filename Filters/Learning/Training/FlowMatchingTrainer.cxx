// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FlowMatchingTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Learning/Layers/DensePoisson.h"
#include "Learning/Layers/MeshTensors.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Models/InitialWeights.h"
#include "Learning/Models/PoissonNet.h"
#include "Learning/Training/AdamMoments.h"
#include "Learning/Training/TrainingCheckpoint.h"
#include "Learning/Training/TrainingSources.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace surfsynth
{

namespace
{
/// A dense inverse of more vertices than this takes more memory and time than it saves.
constexpr Index LargestDenseInverse = 10000;

PoissonNetOptions NetworkOptions(const FlowMatchingTrainingOptions& options, const TrainingSources& sources)
{
  PoissonNetOptions network;
  network.InputChannels = network.OutputChannels = sources.Components;
  network.Width = options.Width;
  network.Blocks = options.Blocks;
  network.ComplexLayers = options.ComplexLayers;
  network.InnerProducts = options.InnerProducts;
  network.ExtraFeatures = 1 + sources.Sources.front().Condition.cols();
  network.Head = sources.Frame.GeneratesPositions() ? PoissonNetHead::GradientDomain : PoissonNetHead::Linear;
  return network;
}

torch::Device ChooseDevice(TrainingDevice wanted)
{
  const bool available = torch::cuda::is_available();
  if (wanted == TrainingDevice::CUDA && !available)
  {
    throw InvalidInput("FlowMatchingTrainer: the device is CUDA and LibTorch finds none; expected Auto or CPU here.");
  }
  return wanted != TrainingDevice::CPU && available ? torch::kCUDA : torch::kCPU;
}

torch::Tensor ToTensor(const FeatureMatrix& matrix)
{
  return torch::from_blob(const_cast<float*>(matrix.data()), { matrix.rows(), matrix.cols() }, torch::kFloat32).clone();
}

ModelTensor ToModelTensor(const torch::Tensor& tensor)
{
  const torch::Tensor values = tensor.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  const float* data = values.data_ptr<float>();
  return { values.sizes().vec(), std::vector<float>(data, data + values.numel()) };
}

/// What the network sees in one iteration on one surface.
struct Batch
{
  torch::Tensor State;     ///< f_t, [B, V, C]
  torch::Tensor Condition; ///< [B, V, 4 + E]
  torch::Tensor Delta;     ///< f_1 - f_0, [B, V, C]
};
}

class FlowMatchingTrainer::Internals
{
public:
  Internals(SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress)
    : Options(options)
    , Device(ChooseDevice(options.Device))
    , DatasetHash(ContentHash(dataset))
    , Data(PrepareSources(std::move(dataset), options.Encoder ? &*options.Encoder : nullptr, options.Noise,
        options.Seed, progress))
    , Network(MakePoissonNet(InitialPoissonNet(NetworkOptions(options, this->Data), options.Seed)))
  {
    this->Network->to(this->Device);
    for (const TrainingSource& source : this->Data.Sources)
    {
      MeshTensors& mesh = this->Meshes.emplace_back(source.Operators, torch::TensorOptions(torch::kFloat32).device(this->Device));
      if (this->Device.is_cuda() && source.Operators.NumberOfPoints() <= LargestDenseInverse)
      {
        UseDenseInverse(mesh);
      }
      this->Conditions.push_back(ToTensor(source.Condition).to(this->Device));
    }
    this->Adam = std::make_unique<torch::optim::Adam>(
      this->Network->parameters(), torch::optim::AdamOptions(options.LearningRate));
    for (const torch::Tensor& parameter : this->Network->parameters())
    {
      this->Averages.push_back(parameter.detach().clone());
    }
  }

  TrainingStep Step();
  double LearningRate() const;
  TrainingCheckpoint Checkpoint();
  void Restore(const std::string& path, const TrainingCheckpoint& checkpoint);

  FlowMatchingTrainingOptions Options;
  torch::Device Device;
  std::uint64_t DatasetHash;
  TrainingSources Data;
  PoissonNet Network{ nullptr };
  std::vector<TrainingStep> History;
  std::vector<torch::Tensor> Averages; ///< of the parameters, in their order

private:
  std::int64_t Iteration() const { return static_cast<std::int64_t>(this->History.size()); }
  Batch MakeBatch(std::size_t source, std::int64_t first, std::int64_t count) const;
  void Accumulate(TrainingStep& step);
  void UpdateAverages();

  std::vector<MeshTensors> Meshes;
  std::vector<torch::Tensor> Conditions;
  std::unique_ptr<torch::optim::Adam> Adam;
};

/// Slots @p first to @p first + @p count of the batch of this iteration, all on one surface.
Batch FlowMatchingTrainer::Internals::MakeBatch(std::size_t number, std::int64_t first, std::int64_t count) const
{
  const TrainingSource& source = this->Data.Sources[number];
  const std::int64_t vertices = source.Operators.NumberOfPoints();
  const std::int64_t components = this->Data.Components;
  const torch::Tensor data = torch::empty({ count, vertices, components }, torch::kFloat32);
  const torch::Tensor noise = torch::empty({ count, vertices, components }, torch::kFloat64);
  const torch::Tensor times = torch::empty({ count, 1, 1 }, torch::kFloat32);
  for (std::int64_t slot = 0; slot < count; ++slot)
  {
    NormalKey key;
    key.Seed = this->Options.Seed;
    key.Sample = static_cast<std::uint32_t>(this->Iteration());
    key.Component = static_cast<std::uint32_t>(first + slot);
    const std::int64_t sample = UniformIndex(key, 1, source.Samples.rows());
    times.data_ptr<float>()[slot] = static_cast<float>(Uniform(key, 2));
    std::copy_n(source.Samples.row(sample).data(), vertices * components,
      data.data_ptr<float>() + slot * vertices * components);
  }
  SampleRequest request;
  request.Seed = this->Options.Seed;
  request.FirstSample = static_cast<std::uint32_t>(this->Iteration() * this->Options.BatchSize + first);
  request.NumberOfSamples = static_cast<std::uint32_t>(count);
  request.NumberOfComponents = static_cast<std::uint32_t>(components);
  request.Scale = this->Data.Frame.Noise.Scale;
  source.Noise->SampleInto(request,
    [&](std::uint32_t sample) {
      return noise.data_ptr<double>() + (sample - request.FirstSample) * vertices * components;
    });

  const MeshTensors& mesh = this->Meshes[number];
  torch::Tensor start = noise.to(this->Device, torch::kFloat32);
  if (this->Data.Frame.GeneratesPositions())
  {
    start = start - MassMean(mesh, start);
  }
  const torch::Tensor end = data.to(this->Device);
  const torch::Tensor time = times.to(this->Device);
  const torch::Tensor& condition = this->Conditions[number];
  return { (1.0 - time) * start + time * end,
    torch::cat({ time.expand({ count, vertices, 1 }), condition.expand({ count, -1, -1 }) }, -1), end - start };
}

double FlowMatchingTrainer::Internals::LearningRate() const
{
  const std::vector<std::int64_t> milestones =
    this->Options.Milestones.empty() ? std::vector<std::int64_t>{ this->Options.Iterations / 4 } : this->Options.Milestones;
  const auto passed = std::count_if(
    milestones.begin(), milestones.end(), [this](std::int64_t milestone) { return this->Iteration() >= milestone; });
  return this->Options.LearningRate * std::pow(this->Options.LearningRateFactor, static_cast<double>(passed));
}

/// The loss of this iteration and its gradient, which is added to that of the parameters.
void FlowMatchingTrainer::Internals::Accumulate(TrainingStep& step)
{
  const std::int64_t groups = this->Options.SourcesPerBatch;
  const std::int64_t size = this->Options.BatchSize / groups;
  for (std::int64_t group = 0; group < groups; ++group)
  {
    NormalKey key;
    key.Seed = this->Options.Seed;
    key.Sample = static_cast<std::uint32_t>(this->Iteration());
    key.Component = static_cast<std::uint32_t>(group);
    const auto source =
      static_cast<std::size_t>(UniformIndex(key, 0, static_cast<std::int64_t>(this->Data.Sources.size())));
    const Batch batch = this->MakeBatch(source, group * size, size);
    const MeshTensors& mesh = this->Meshes[source];
    const FlowMatchingLoss loss =
      ComputeFlowMatchingLoss(mesh, this->Network->forward(mesh, batch.State, batch.Condition), batch.Delta);
    const auto share = 1.0 / static_cast<double>(groups);
    ((this->Options.VertexWeight * loss.Vertex + this->Options.JacobianWeight * loss.Jacobian) * share).backward();
    step.VertexLoss += share * loss.Vertex.item<double>();
    step.JacobianLoss += share * loss.Jacobian.item<double>();
  }
  step.Loss = this->Options.VertexWeight * step.VertexLoss + this->Options.JacobianWeight * step.JacobianLoss;
}

TrainingStep FlowMatchingTrainer::Internals::Step()
{
  TrainingStep step;
  step.Iteration = this->Iteration() + 1;
  step.LearningRate = this->LearningRate();
  static_cast<torch::optim::AdamOptions&>(this->Adam->param_groups()[0].options()).lr(step.LearningRate);
  this->Adam->zero_grad();
  const double limit =
    this->Options.GradientClip > 0.0 ? this->Options.GradientClip : std::numeric_limits<double>::infinity();
  bool finite = true;
  try
  {
    this->Accumulate(step);
    step.GradientNorm = torch::nn::utils::clip_grad_norm_(this->Network->parameters(), limit);
  }
  catch (const InvalidInput&) // the solver's, of a right-hand side that is not finite: all else was checked before
  {
    finite = false;
  }
  if (!finite || !std::isfinite(step.Loss) || !std::isfinite(step.GradientNorm))
  {
    throw SolverFailure("FlowMatchingTrainer: the loss or its gradient is not finite in iteration " +
      std::to_string(step.Iteration) + "; expected a lower learning rate, or samples without outliers.");
  }
  this->Adam->step();
  this->UpdateAverages();
  this->History.push_back(step);
  return step;
}

void FlowMatchingTrainer::Internals::UpdateAverages()
{
  const torch::NoGradGuard noGradients;
  const auto done = static_cast<double>(this->Iteration());
  const double keep = std::min(this->Options.WeightAveraging, (1.0 + done) / (10.0 + done));
  const std::vector<torch::Tensor> parameters = this->Network->parameters();
  for (std::size_t k = 0; k < parameters.size(); ++k)
  {
    if (this->Options.WeightAveraging > 0.0)
    {
      this->Averages[k].mul_(keep).add_(parameters[k], 1.0 - keep);
    }
    else
    {
      this->Averages[k].copy_(parameters[k]);
    }
  }
}

TrainingCheckpoint FlowMatchingTrainer::Internals::Checkpoint()
{
  TrainingCheckpoint checkpoint;
  checkpoint.History = this->History;
  checkpoint.Recipe = RecipeOf(this->Options, this->DatasetHash);
  std::size_t number = 0;
  for (const auto& parameter : this->Network->named_parameters())
  {
    const std::string& name = parameter.key();
    checkpoint.Tensors["network." + name] = ToModelTensor(parameter.value());
    checkpoint.Tensors["average." + name] = ToModelTensor(this->Averages[number++]);
    const AdamMoments moments = GetMoments(*this->Adam, parameter.value());
    if (moments.Mean.defined())
    {
      checkpoint.Tensors["adam_mean." + name] = ToModelTensor(moments.Mean);
      checkpoint.Tensors["adam_square." + name] = ToModelTensor(moments.Square);
    }
  }
  return checkpoint;
}

void FlowMatchingTrainer::Internals::Restore(const std::string& path, const TrainingCheckpoint& checkpoint)
{
  RequireSameRecipe(path, RecipeOf(this->Options, this->DatasetHash), checkpoint.Recipe);
  const torch::NoGradGuard noGradients;
  const auto read = [&](const std::string& name, const torch::Tensor& like)
  {
    const auto found = checkpoint.Tensors.find(name);
    if (found == checkpoint.Tensors.end() || found->second.Shape != like.sizes().vec())
    {
      throw ModelMismatch(path + ": the tensor \"" + name + "\" is missing or has another shape; expected a checkpoint "
                                 "of this training.");
    }
    return torch::from_blob(const_cast<float*>(found->second.Values.data()), found->second.Shape, torch::kFloat32)
      .to(like.device(), torch::kFloat32, false, true);
  };
  const auto parameters = this->Network->named_parameters();
  // All that can fail comes first, so that a training is not left half restored.
  std::vector<std::pair<torch::Tensor, AdamMoments>> restored;
  std::vector<torch::Tensor> averages;
  for (const auto& parameter : parameters)
  {
    const std::string& name = parameter.key();
    const torch::Tensor& like = parameter.value();
    AdamMoments moments;
    if (!checkpoint.History.empty())
    {
      moments = { read("adam_mean." + name, like), read("adam_square." + name, like) };
    }
    restored.emplace_back(read("network." + name, like), std::move(moments));
    averages.push_back(read("average." + name, like));
  }
  this->History = checkpoint.History;
  this->Averages = std::move(averages);
  for (std::size_t k = 0; k < restored.size(); ++k)
  {
    torch::Tensor parameter = parameters[k].value();
    parameter.copy_(restored[k].first);
    if (restored[k].second.Mean.defined())
    {
      SetMoments(*this->Adam, parameter, restored[k].second, this->Iteration());
    }
  }
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

TrainingStep FlowMatchingTrainer::Step() { return this->Impl->Step(); }

std::int64_t FlowMatchingTrainer::Iteration() const { return static_cast<std::int64_t>(this->Impl->History.size()); }

const std::vector<TrainingStep>& FlowMatchingTrainer::History() const { return this->Impl->History; }

const FlowMatchingTrainingOptions& FlowMatchingTrainer::Options() const { return this->Impl->Options; }

std::string FlowMatchingTrainer::DeviceName() const { return this->Impl->Device.is_cuda() ? "CUDA" : "CPU"; }

void FlowMatchingTrainer::SaveCheckpoint(const std::string& path) const
{
  WriteCheckpoint(path, this->Impl->Checkpoint());
}

void FlowMatchingTrainer::LoadCheckpoint(const std::string& path)
{
  this->Impl->Restore(path, ReadCheckpoint(path));
}

FlowMatchingModel FlowMatchingTrainer::Model() const
{
  FlowMatchingModel model = this->Impl->Data.Frame;
  model.Iterations = this->Iteration();
  model.Velocity = ModelOf(*this->Impl->Network);
  model.Velocity.Normalisation = InputNormalisation::SurfaceArea;
  std::size_t number = 0;
  for (const auto& parameter : this->Impl->Network->named_parameters())
  {
    model.Velocity.Tensors[parameter.key()] = ToModelTensor(this->Impl->Averages[number++]);
  }
  return model;
}

} // namespace surfsynth
