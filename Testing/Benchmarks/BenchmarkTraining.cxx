// SPDX-License-Identifier: BSD-3-Clause
// Steps of trainings beside the rate of sgemm, per second of processor time.
#include "ExampleMeshes.h"
#include "ProductRate.h"
#include "SmallLatents.h"
#include "SmallTextures.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Core/Tangent/TangentHierarchy.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "Inference/FieldLatents/FieldLatentOperations.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"
#include "Learning/Layers/FusedLayers.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Losses/GeometricTextureLosses.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/FieldLatentTrainer.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/LatentDiffusionTrainer.h"
#include "Learning/Training/SampleGradients.h"

#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace surfsynth::bench
{
namespace
{

/// Operations of one step: those of the forward pass, and twice as many for the derivatives.
double StepOperations(const FieldLatentTrainingOptions& options)
{
  const FieldLatentOptions& network = options.Network;
  const double decoder = static_cast<double>(network.SamplesPerRing) * NeuralFieldOperations(network);
  return 3.0 * static_cast<double>(options.BatchSize) * (EncoderOperations(network, network.SamplesPerRing) + decoder);
}

void FieldLatentStep(benchmark::State& state, const FieldLatentOptions& network, std::int64_t batch)
{
  FieldLatentTrainingOptions options;
  options.Network = network;
  options.BatchSize = batch;
  options.Device = TrainingDevice::CPU;
  FieldLatentTrainer trainer(test::SmallTextures(), options);
  trainer.Step();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    trainer.Step();
  }
  const double seconds = ProcessorSeconds() - start;
  const double rate = StepOperations(options) * static_cast<double>(state.iterations()) / seconds;
  state.counters["GFLOP"] = 1e-9 * StepOperations(options);
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
  state.counters["OfProductRate"] = rate / ProductRate();
}

/// Training of the diffusion on one surface of 3,000 vertices, one step done; d = 8 tangent vectors.
LatentDiffusionTrainer DiffusionTraining(const LatentDiffusionOptions& network)
{
  LatentSurface surface;
  surface.Mesh = test::Torus(75, 40);
  const Index vertices = surface.Mesh.NumberOfPoints();
  surface.Means = LatentColumns::Random(vertices, 2 * network.LatentDimension);
  surface.Deviations = LatentColumns::Constant(vertices, network.LatentDimension, 0.1F);
  LatentDiffusionTrainingOptions options;
  options.Network = network;
  options.BatchSize = 1;
  options.Device = TrainingDevice::CPU;
  LatentDiffusionTrainer trainer({ { surface }, "" }, options);
  trainer.Step();
  return trainer;
}

/// Operations of the forward pass, and twice as many for the derivatives.
double DiffusionStepOperations(const LatentDiffusionOptions& network)
{
  const TangentHierarchy levels{ OneRings(test::Torus(75, 40)) };
  return 3.0 * LatentDiffusionOperations(network, levels.Fine.NumberOfVertices(), levels.Coarse.NumberOfVertices());
}

/// One step of the diffusion.
void LatentDiffusionStep(benchmark::State& state, const LatentDiffusionOptions& network)
{
  LatentDiffusionTrainer trainer = DiffusionTraining(network);
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    trainer.Step();
  }
  const double seconds = ProcessorSeconds() - start;
  const double operations = DiffusionStepOperations(network);
  const double rate = operations * static_cast<double>(state.iterations()) / seconds;
  state.counters["GFLOP"] = 1e-9 * operations;
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
  state.counters["OfProductRate"] = rate / ProductRate();
}

/// Seconds of a step by the clock on some threads.
template <typename Training>
double StepSeconds(Training& training, int threads)
{
  at::set_num_threads(threads);
  const auto start = std::chrono::steady_clock::now();
  training.Step();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Steps on one and on two threads in turn, by the clock: so both see the same load of the machine. OfProductRate1 and
/// OfProductRate2 are shares of the shortest steps in the rate of sgemm on as many threads, SpeedUp is the ratio of the medians, BestSpeedUp
/// that of the shortest steps.
template <typename Training>
void CompareThreads(benchmark::State& state, Training& training, double operations)
{
  std::array<std::vector<double>, 2> seconds;
  for ([[maybe_unused]] auto step : state)
  {
    seconds[0].push_back(StepSeconds(training, 1));
    seconds[1].push_back(StepSeconds(training, 2));
  }
  at::set_num_threads(1);
  for (std::vector<double>& times : seconds)
  {
    std::sort(times.begin(), times.end());
  }
  const double rate = ProductRate();
  const auto median = [](const std::vector<double>& times) { return times[times.size() / 2]; };
  for (int threads = 1; threads <= 2; ++threads)
  {
    const double shortest = seconds[static_cast<std::size_t>(threads - 1)].front();
    state.counters["OfProductRate" + std::to_string(threads)] = operations / (shortest * threads * rate);
  }
  state.counters["SpeedUp"] = median(seconds[0]) / median(seconds[1]);
  state.counters["BestSpeedUp"] = seconds[0].front() / seconds[1].front();
}

void LatentDiffusionThreads(benchmark::State& state, const LatentDiffusionOptions& network)
{
  LatentDiffusionTrainer trainer = DiffusionTraining(network);
  CompareThreads(state, trainer, DiffusionStepOperations(network));
}

/// Real multiplications and additions of one evaluation of a velocity field with extra features, in matrix products.
struct PoissonNetOperations
{
  double Forward;  ///< of the forward pass
  double Repeated; ///< of what the backward pass computes again
};

/// @param options modulated blocks, a gradient-domain head without modulation, no inner products
PoissonNetOperations OperationsOf(const PoissonNetOptions& options, double vertices, double faces)
{
  const auto width = static_cast<double>(options.Width);
  const double complexLayers = 4.0 * static_cast<double>(options.ComplexLayers - 1) * faces;
  const double atFaces = 2.0 * faces + complexLayers;
  const double mlp = 6.0 * vertices;
  const double block = atFaces + mlp + 3.0 * vertices; // the modulator's first map, and the last complex layer
  const double square = 2.0 * width * width;
  const auto blocks = static_cast<double>(options.Blocks);
  return { square * (blocks * block + complexLayers), square * (blocks * (atFaces + mlp) + complexLayers) };
}

/// A network of three blocks and four samples on a sphere of 6,802 triangles.
class FlowMatchingBatch
{
public:
  /// @param fused false for the plain expressions, with LibTorch's own derivatives
  FlowMatchingBatch(std::int64_t width, bool fused)
    : Sphere(test::Scaled(test::IrregularSphere(3), 0.28))
    , Mesh(BuildPoissonOperators(this->Sphere, MeshTopology(this->Sphere)), torch::kFloat32, this->Sphere.Points)
    , Fused(fused)
  {
    if (!fused)
    {
      this->Mesh.Tables.reset();
      this->Mesh.Incidence.reset();
    }
    this->Options.Width = width;
    this->Options.Blocks = 3;
    this->Options.ExtraFeatures = 4;
    this->Network = MakePoissonNet(InitialPoissonNet(this->Options, 1));
    const Index vertices = this->Sphere.NumberOfPoints();
    this->X = torch::randn({ Samples, vertices, 3 });
    this->Condition = torch::randn({ Samples, vertices, 4 });
    this->Delta = torch::randn({ Samples, vertices, 3 });
  }

  /// Forward and backward pass, as the training has them: each sample on one thread, the plain expressions all at once.
  void Step()
  {
    this->Network->zero_grad();
    if (!this->Fused)
    {
      this->Loss(0, Samples).mean().backward();
      return;
    }
    AddSampleGradients(this->Network->parameters(), Samples,
      [this](std::int64_t sample) { return this->Loss(sample, 1).sum() / static_cast<double>(Samples); });
  }

  /// Counted operations of Step().
  double Operations() const
  {
    const PoissonNetOperations counted = OperationsOf(this->Options, static_cast<double>(this->Sphere.NumberOfPoints()),
      static_cast<double>(this->Sphere.NumberOfTriangles()));
    return static_cast<double>(Samples) * (3.0 * counted.Forward + counted.Repeated);
  }

private:
  static constexpr std::int64_t Samples = 4;

  torch::Tensor Loss(std::int64_t first, std::int64_t count)
  {
    const auto part = [&](const torch::Tensor& tensor) { return tensor.narrow(0, first, count); };
    const FlowMatchingLoss loss = ComputeFlowMatchingLoss(
      this->Mesh, this->Network->forward(this->Mesh, part(this->X), part(this->Condition)), part(this->Delta));
    return loss.Vertex + loss.Jacobian;
  }

  TriangleMesh Sphere;
  MeshTensors Mesh;
  bool Fused;
  PoissonNetOptions Options;
  PoissonNet Network{ nullptr };
  torch::Tensor X;
  torch::Tensor Condition;
  torch::Tensor Delta;
};

/// Steps of FlowMatchingBatch.
void FlowMatchingStep(benchmark::State& state, std::int64_t width, bool fused)
{
  FlowMatchingBatch batch(width, fused);
  batch.Step();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    batch.Step();
  }
  const double seconds = (ProcessorSeconds() - start) / static_cast<double>(state.iterations());
  state.counters["GFLOP"] = 1e-9 * batch.Operations();
  state.counters["OfProductRate"] = batch.Operations() / seconds / ProductRate();
}

/// Steps of FlowMatchingBatch on one and on two threads in turn, counted as LatentDiffusionThreads().
void FlowMatchingThreads(benchmark::State& state, std::int64_t width)
{
  FlowMatchingBatch batch(width, true);
  batch.Step();
  CompareThreads(state, batch, batch.Operations());
}

/// One level of a geometric texture on a torus of 20,480 triangles, in the channels of the fourth level.
class TextureLevel
{
public:
  /// @param fused false for the plain expressions, with LibTorch's own derivatives
  TextureLevel(std::int64_t channels, bool fused)
    : Torus(test::Torus(128, 80))
    , Tables(Torus, torch::kFloat32)
  {
    if (!fused)
    {
      this->Tables.OfNeighbors.reset();
    }
    GeometricTextureOptions options;
    options.Levels = Level + 1;
    options.MaximumChannels = channels;
    this->OfGenerator = options.GeneratorChannels(Level);
    this->OfCritic = options.DiscriminatorChannels(Level);
    const auto network = [&options](bool discriminator) {
      return MakeGeometricTextureNetwork(
        options, discriminator, InitialGeometricTextureTensors(options, discriminator, 1));
    };
    this->Generator = network(false);
    this->Critic = network(true);
    this->Positions = torch::from_blob(this->Torus.Points.data(), { this->Torus.NumberOfPoints(), 3 }, torch::kFloat64)
                        .to(torch::kFloat32);
    this->Positions = this->Positions / MeanEdgeLength(this->Torus);
    this->Noise = 0.1 * torch::randn_like(this->Positions);
    this->Real = EdgeFeatureTensor(this->Tables, this->Positions);
  }

  /// Derivatives of two steps of the discriminator and three of the generator.
  void Iteration()
  {
    for (int k = 0; k < 2; ++k)
    {
      this->DiscriminatorStep();
    }
    for (int k = 0; k < 3; ++k)
    {
      this->GeneratorStep();
    }
  }

  /// Counted operations of the products of Iteration(). A pass of a network forward or back, by its input or by its weights,
  /// counts once; a gradient penalty takes six.
  double Operations() const { return 20.0 * this->PassOf(this->OfGenerator) + 30.0 * this->PassOf(this->OfCritic); }

private:
  static constexpr std::int64_t Level = 3;

  double PassOf(const GeometricTextureChannels& channels) const
  {
    double products = 3.0 * static_cast<double>(channels[0] * channels[1]); // three edges
    for (std::size_t k = 1; k + 1 < channels.size(); ++k)
    {
      products += 2.0 * static_cast<double>(channels[k] * channels[k + 1]);
    }
    return 2.0 * static_cast<double>(this->Torus.NumberOfTriangles()) * products;
  }

  GeometricTextureLevelNetworkImpl& LevelOf(GeometricTextureNetwork& network)
  {
    return network->Level(static_cast<std::size_t>(Level));
  }

  void DiscriminatorStep()
  {
    torch::Tensor fake;
    {
      const torch::NoGradGuard noGradients;
      fake = EdgeFeatureTensor(
        this->Tables, Displaced(this->LevelOf(this->Generator), this->Tables, this->Positions, this->Noise));
    }
    GeometricTextureLevelNetworkImpl& critic = this->LevelOf(this->Critic);
    critic.zero_grad();
    GradientPenalty(critic, this->Tables, this->Real, fake, 0.3).backward();
    (CriticValue(critic, this->Tables, fake) - CriticValue(critic, this->Tables, this->Real)).backward();
  }

  void GeneratorStep()
  {
    GeometricTextureLevelNetworkImpl& generator = this->LevelOf(this->Generator);
    generator.zero_grad();
    const auto freeze = [this](bool frozen) {
      for (torch::Tensor& parameter : this->Critic->parameters())
      {
        parameter.set_requires_grad(!frozen);
      }
    };
    freeze(true);
    const torch::Tensor fake = Displaced(generator, this->Tables, this->Positions, this->Noise);
    const torch::Tensor adversarial = -CriticValue(
      this->LevelOf(this->Critic), this->Tables, EdgeFeatureTensor(this->Tables, fake));
    const torch::Tensor reconstructed = Displaced(generator, this->Tables, this->Positions);
    (ReconstructionLoss(reconstructed, this->Positions) + adversarial).backward();
    freeze(false);
  }

  TriangleMesh Torus;
  FaceTables Tables;
  GeometricTextureChannels OfGenerator;
  GeometricTextureChannels OfCritic;
  GeometricTextureNetwork Generator{ nullptr };
  GeometricTextureNetwork Critic{ nullptr };
  torch::Tensor Positions;
  torch::Tensor Noise;
  torch::Tensor Real; ///< features
};

/// Iterations of the fused and of the plain expressions in turn: so both see the same load of the machine. Counted per
/// second of processor time.
void GeometricTextureIteration(benchmark::State& state, std::int64_t channels)
{
  std::array<TextureLevel, 2> levels = { TextureLevel(channels, true), TextureLevel(channels, false) };
  std::array<double, 2> seconds{};
  for ([[maybe_unused]] auto step : state)
  {
    for (std::size_t k = 0; k < 2; ++k)
    {
      const double start = ProcessorSeconds();
      levels[k].Iteration();
      seconds[k] += ProcessorSeconds() - start;
    }
  }
  const double operations = levels[0].Operations() * static_cast<double>(state.iterations());
  state.counters["GFLOP"] = 1e-9 * levels[0].Operations();
  state.counters["GFLOPperSecond"] = 1e-9 * operations / seconds[0];
  state.counters["PlainGFLOPperSecond"] = 1e-9 * operations / seconds[1];
  state.counters["OfProductRate"] = operations / seconds[0] / ProductRate();
  state.counters["SpeedUp"] = seconds[1] / seconds[0];
}

/// A torus with waves at four scales, of 320 to 20,480 triangles.
MultiscaleDataset WavesOfTorus()
{
  MultiscaleDataset dataset;
  TriangleMesh mesh = test::Torus(20, 8);
  for (int level = 0; level < 4; ++level)
  {
    mesh = level > 0 ? SubdivideAtMidpoints(mesh).Mesh : mesh;
    TriangleMesh waves = mesh;
    for (Eigen::Index v = 0; v < waves.Points.rows(); ++v)
    {
      waves.Points(v, 2) += 0.05 * std::sin(9.0 * waves.Points(v, 0)) * std::cos(8.0 * waves.Points(v, 1));
    }
    dataset.Levels.push_back(waves);
  }
  return dataset;
}

/// Whole iterations of the finest level by the three objectives in turn; processor time.
void TextureObjectives(benchmark::State& state)
{
  std::vector<GeometricTextureTrainer> trainers;
  for (const TextureObjective objective :
    { TextureObjective::FlowMatching, TextureObjective::Adversarial, TextureObjective::SlicedWasserstein })
  {
    GeometricTextureTrainingOptions options;
    options.Objective = objective;
    options.Network.MaximumChannels = 64;
    options.IterationsOfLevels = { 1, 1, 1, 100000 };
    options.Device = TrainingDevice::CPU;
    trainers.emplace_back(WavesOfTorus(), options);
    for (int coarse = 0; coarse < 4; ++coarse)
    {
      trainers.back().Step();
    }
  }
  std::vector<double> seconds(trainers.size());
  for ([[maybe_unused]] auto step : state)
  {
    for (std::size_t k = 0; k < trainers.size(); ++k)
    {
      const double start = ProcessorSeconds();
      trainers[k].Step();
      seconds[k] += ProcessorSeconds() - start;
    }
  }
  state.counters["FlowMilliseconds"] = 1e3 * seconds[0] / static_cast<double>(state.iterations());
  state.counters["AdversarialOverFlow"] = seconds[1] / seconds[0];
  state.counters["SlicedOverFlow"] = seconds[2] / seconds[0];
}

} // namespace
} // namespace surfsynth::bench

/// On one thread, OMP_NUM_THREADS=1, but for LatentDiffusionThreads and FlowMatchingThreads.
int main(int argc, char** argv)
{
  using namespace surfsynth;
#ifdef __GLIBC__
  // As surfacesynthesis-train: memory that tensors give back is kept.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
  {
    return EXIT_FAILURE;
  }
  const SingleThreadedBlas blas;
  benchmark::RegisterBenchmark("FieldLatentStep/small", [](benchmark::State& state) {
    bench::FieldLatentStep(state, FieldLatentOptions::Small(), 48);
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("FieldLatentStep/paper", [](benchmark::State& state) {
    bench::FieldLatentStep(state, FieldLatentOptions::Paper(), 16);
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("LatentDiffusionStep/small", [](benchmark::State& state) {
    bench::LatentDiffusionStep(state, LatentDiffusionOptions::Small());
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("LatentDiffusionThreads/small", [](benchmark::State& state) {
    bench::LatentDiffusionThreads(state, LatentDiffusionOptions::Small());
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("LatentDiffusionStep/paper", [](benchmark::State& state) {
    bench::LatentDiffusionStep(state, LatentDiffusionOptions::Paper());
  })->Unit(benchmark::kMillisecond);
  for (const std::int64_t channels : { 64, 128 })
  {
    benchmark::RegisterBenchmark(("GeometricTextureIteration/channels:" + std::to_string(channels)).c_str(),
      [channels](benchmark::State& state) { bench::GeometricTextureIteration(state, channels); })
      ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("TextureObjectives/small", bench::TextureObjectives)->Unit(benchmark::kMillisecond);
  for (const std::int64_t width : { 48, 64, 128 })
  {
    for (const bool fused : { true, false })
    {
      benchmark::RegisterBenchmark(
        ("FlowMatchingStep/" + std::string(fused ? "fused" : "plain") + "/width:" + std::to_string(width)).c_str(),
        [width, fused](benchmark::State& state) { bench::FlowMatchingStep(state, width, fused); })
        ->Unit(benchmark::kMillisecond);
    }
    benchmark::RegisterBenchmark(("FlowMatchingThreads/width:" + std::to_string(width)).c_str(),
      [width](benchmark::State& state) { bench::FlowMatchingThreads(state, width); })
      ->Unit(benchmark::kMillisecond);
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return EXIT_SUCCESS;
}
