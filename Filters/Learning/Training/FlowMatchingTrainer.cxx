// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FlowMatchingTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Learning/Layers/DensePoisson.h"
#include "Learning/Layers/MeshTensors.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Training/NetworkTraining.h"
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

/// Tells encoders apart whose results have the same number of channels.
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

/// What the network sees in one iteration on one surface.
struct Batch
{
  torch::Tensor State;     ///< f_t, [B, V, C]
  torch::Tensor Condition; ///< [B, V, 4 + E]
  torch::Tensor Delta;     ///< f_1 - f_0, [B, V, C]
};
} // namespace

class FlowMatchingTrainer::Internals
{
public:
  Internals(SignalDataset dataset, const FlowMatchingTrainingOptions& options, const Progress& progress)
    : Options(options)
    , DatasetHash(ContentHash(dataset))
    , Data(PrepareSources(
        std::move(dataset), options.Encoder ? &*options.Encoder : nullptr, options.Noise, options.Seed, progress))
    , Training(NetworkOptions(options, this->Data), options)
  {
    const torch::Device& device = this->Training.Device();
    for (const TrainingSource& source : this->Data.Sources)
    {
      MeshTensors& mesh = this->Meshes.emplace_back(
        source.Operators, torch::TensorOptions(torch::kFloat32).device(device));
      if (device.is_cuda() && source.Operators.NumberOfPoints() <= LargestDenseInverse)
      {
        UseDenseInverse(mesh);
      }
      this->Conditions.push_back(ToTensor(source.Condition, device));
    }
  }

  void Accumulate(TrainingStep& step);
  std::map<std::string, std::string> Recipe() const;

  FlowMatchingTrainingOptions Options;
  std::uint64_t DatasetHash;
  TrainingSources Data;
  NetworkTraining Training;

private:
  NormalKey KeyOf(std::int64_t slot) const;
  Batch MakeBatch(std::size_t source, std::int64_t first, std::int64_t count) const;

  std::vector<MeshTensors> Meshes;
  std::vector<torch::Tensor> Conditions;
};

/// What must be the same when a training goes on.
std::map<std::string, std::string> FlowMatchingTrainer::Internals::Recipe() const
{
  std::map<std::string, std::string> recipe = RecipeOf(this->Options, "flow_matching");
  recipe["width"] = std::to_string(this->Options.Width);
  recipe["blocks"] = std::to_string(this->Options.Blocks);
  recipe["complex_layers"] = std::to_string(this->Options.ComplexLayers);
  recipe["inner_products"] = this->Options.InnerProducts ? "yes" : "no";
  recipe["noise"] = std::to_string(static_cast<int>(this->Options.Noise.Model));
  recipe["noise_screening"] = FormatExact(this->Options.Noise.Screening);
  recipe["noise_eigenpairs"] = std::to_string(this->Options.Noise.Eigenpairs);
  recipe["noise_smoothing"] = FormatExact(this->Options.Noise.Smoothing);
  recipe["noise_scale"] = FormatExact(this->Options.Noise.Scale);
  recipe["encoder"] = this->Options.Encoder ? Identity(*this->Options.Encoder) : "none";
  recipe["signal"] = this->Data.Frame.SignalName;
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
    const NormalKey key = this->KeyOf(first + slot);
    const std::int64_t sample = UniformIndex(key, 1, source.Samples.rows());
    times.data_ptr<float>()[slot] = static_cast<float>(Uniform(key, 2));
    std::copy_n(
      source.Samples.row(sample).data(), vertices * components, data.data_ptr<float>() + slot * vertices * components);
  }
  SampleRequest request;
  request.Seed = this->Options.Seed;
  request.FirstSample = static_cast<std::uint32_t>(this->Training.Iteration() * this->Options.BatchSize + first);
  request.NumberOfSamples = static_cast<std::uint32_t>(count);
  request.NumberOfComponents = static_cast<std::uint32_t>(components);
  request.Scale = this->Data.Frame.Noise.Scale;
  source.Noise->SampleInto(request, [&](std::uint32_t sample) {
    return noise.data_ptr<double>() + (sample - request.FirstSample) * vertices * components;
  });

  const MeshTensors& mesh = this->Meshes[number];
  torch::Tensor start = noise.to(this->Training.Device(), torch::kFloat32);
  if (this->Data.Frame.GeneratesPositions())
  {
    start = start - MassMean(mesh, start);
  }
  const torch::Tensor end = data.to(this->Training.Device());
  const torch::Tensor time = times.to(this->Training.Device());
  const torch::Tensor& condition = this->Conditions[number];
  return { (1.0 - time) * start + time * end,
    torch::cat({ time.expand({ count, vertices, 1 }), condition.expand({ count, -1, -1 }) }, -1), end - start };
}

/// The loss of this iteration and its gradient, which is added to that of the parameters.
void FlowMatchingTrainer::Internals::Accumulate(TrainingStep& step)
{
  const std::int64_t groups = this->Options.SourcesPerBatch;
  const std::int64_t size = this->Options.BatchSize / groups;
  const auto share = 1.0 / static_cast<double>(groups);
  for (std::int64_t group = 0; group < groups; ++group)
  {
    const auto source = static_cast<std::size_t>(
      UniformIndex(this->KeyOf(group), 0, static_cast<std::int64_t>(this->Data.Sources.size())));
    const Batch batch = this->MakeBatch(source, group * size, size);
    const MeshTensors& mesh = this->Meshes[source];
    const FlowMatchingLoss loss = ComputeFlowMatchingLoss(
      mesh, this->Training.Network().forward(mesh, batch.State, batch.Condition), batch.Delta);
    ((this->Options.VertexWeight * loss.Vertex + this->Options.JacobianWeight * loss.Jacobian) * share).backward();
    step.VertexLoss += share * loss.Vertex.item<double>();
    step.JacobianLoss += share * loss.Jacobian.item<double>();
  }
  step.Loss = this->Options.VertexWeight * step.VertexLoss + this->Options.JacobianWeight * step.JacobianLoss;
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

TrainingStep FlowMatchingTrainer::Step()
{
  return this->Impl->Training.Step([this](TrainingStep& step) { this->Impl->Accumulate(step); });
}

std::int64_t FlowMatchingTrainer::Iteration() const { return this->Impl->Training.Iteration(); }

const std::vector<TrainingStep>& FlowMatchingTrainer::History() const { return this->Impl->Training.History(); }

const FlowMatchingTrainingOptions& FlowMatchingTrainer::Options() const { return this->Impl->Options; }

std::string FlowMatchingTrainer::DeviceName() const { return this->Impl->Training.Device().is_cuda() ? "CUDA" : "CPU"; }

void FlowMatchingTrainer::SaveCheckpoint(const std::string& path) const
{
  TrainingCheckpoint checkpoint = this->Impl->Training.Checkpoint();
  checkpoint.Recipe = this->Impl->Recipe();
  WriteCheckpoint(path, checkpoint);
}

void FlowMatchingTrainer::LoadCheckpoint(const std::string& path)
{
  const TrainingCheckpoint checkpoint = ReadCheckpoint(path);
  RequireSameRecipe(path, this->Impl->Recipe(), checkpoint.Recipe);
  this->Impl->Training.Restore(path, checkpoint);
}

FlowMatchingModel FlowMatchingTrainer::Model() const
{
  FlowMatchingModel model = this->Impl->Data.Frame;
  model.Iterations = this->Iteration();
  model.Velocity = this->Impl->Training.Model();
  model.Velocity.Normalisation = InputNormalisation::SurfaceArea;
  return model;
}

} // namespace surfsynth
