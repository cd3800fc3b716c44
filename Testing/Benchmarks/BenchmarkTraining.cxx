// SPDX-License-Identifier: BSD-3-Clause
// Steps of trainings beside the rate of sgemm, per second of processor time.
#include "ExampleMeshes.h"
#include "ProductRate.h"
#include "SmallLatents.h"
#include "SmallTextures.h"

#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Core/Tangent/TangentHierarchy.h"
#include "Inference/FieldLatents/FieldLatentOperations.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"
#include "Learning/Layers/FusedLayers.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/FieldLatentTrainer.h"
#include "Learning/Training/LatentDiffusionTrainer.h"

#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
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
double StepSeconds(LatentDiffusionTrainer& trainer, int threads)
{
  at::set_num_threads(threads);
  const auto start = std::chrono::steady_clock::now();
  trainer.Step();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Steps on one and on two threads in turn, by the clock: so both see the same load of the machine. OfProductRate1 and
/// OfProductRate2 are shares of the shortest steps in the rate of sgemm on as many threads, SpeedUp is the ratio of the medians, BestSpeedUp
/// that of the shortest steps.
void LatentDiffusionThreads(benchmark::State& state, const LatentDiffusionOptions& network)
{
  LatentDiffusionTrainer trainer = DiffusionTraining(network);
  std::array<std::vector<double>, 2> seconds;
  for ([[maybe_unused]] auto step : state)
  {
    seconds[0].push_back(StepSeconds(trainer, 1));
    seconds[1].push_back(StepSeconds(trainer, 2));
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
    state.counters["OfProductRate" + std::to_string(threads)] = DiffusionStepOperations(network) /
      (shortest * threads * rate);
  }
  state.counters["SpeedUp"] = median(seconds[0]) / median(seconds[1]);
  state.counters["BestSpeedUp"] = seconds[0].front() / seconds[1].front();
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

/// Forward and backward pass of a network of three blocks on four signals on a sphere of 5,120 triangles.
/// @param fused false for the plain expressions, with LibTorch's own derivatives
void FlowMatchingStep(benchmark::State& state, std::int64_t width, bool fused)
{
  const TriangleMesh sphere = test::Scaled(test::IrregularSphere(3), 0.28);
  const PoissonOperators operators = BuildPoissonOperators(sphere, MeshTopology(sphere));
  MeshTensors mesh(operators, torch::kFloat32, sphere.Points);
  if (!fused)
  {
    mesh.Tables.reset();
    mesh.Incidence.reset();
  }
  PoissonNetOptions options;
  options.Width = width;
  options.Blocks = 3;
  options.ExtraFeatures = 4;
  const std::int64_t batch = 4;
  PoissonNet network = MakePoissonNet(InitialPoissonNet(options, 1));
  const torch::Tensor x = torch::randn({ batch, sphere.NumberOfPoints(), 3 });
  const torch::Tensor condition = torch::randn({ batch, sphere.NumberOfPoints(), 4 });
  const torch::Tensor delta = torch::randn({ batch, sphere.NumberOfPoints(), 3 });
  const auto run = [&] {
    network->zero_grad();
    const FlowMatchingLoss loss = ComputeFlowMatchingLoss(mesh, network->forward(mesh, x, condition), delta);
    (loss.Vertex + loss.Jacobian).mean().backward();
  };
  run();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    run();
  }
  const double seconds = (ProcessorSeconds() - start) / static_cast<double>(state.iterations());
  const PoissonNetOperations counted = OperationsOf(
    options, static_cast<double>(sphere.NumberOfPoints()), static_cast<double>(sphere.NumberOfTriangles()));
  const double operations = static_cast<double>(batch) * (3.0 * counted.Forward + counted.Repeated);
  state.counters["GFLOP"] = 1e-9 * operations;
  state.counters["OfProductRate"] = operations / seconds / ProductRate();
}

} // namespace
} // namespace surfsynth::bench

/// On one thread, OMP_NUM_THREADS=1, but for LatentDiffusionThreads.
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
  for (const std::int64_t width : { 48, 64, 128 })
  {
    for (const bool fused : { true, false })
    {
      benchmark::RegisterBenchmark(
        ("FlowMatchingStep/" + std::string(fused ? "fused" : "plain") + "/width:" + std::to_string(width)).c_str(),
        [width, fused](benchmark::State& state) { bench::FlowMatchingStep(state, width, fused); })
        ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return EXIT_SUCCESS;
}
