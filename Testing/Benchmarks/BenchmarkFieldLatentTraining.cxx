// SPDX-License-Identifier: BSD-3-Clause
// Steps of the trainings of field latents and of their diffusion beside the rate of sgemm, per second of processor time.
#include "ProductRate.h"
#include "SmallLatents.h"
#include "SmallTextures.h"

#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Core/Tangent/TangentHierarchy.h"
#include "Inference/FieldLatents/FieldLatentOperations.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"
#include "Learning/Training/FieldLatentTrainer.h"
#include "Learning/Training/LatentDiffusionTrainer.h"

#include <benchmark/benchmark.h>

#include <cstdlib>

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

/// One step of the diffusion on one surface of 3,000 vertices; d = 8 tangent vectors.
void LatentDiffusionStep(benchmark::State& state, const LatentDiffusionOptions& network)
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
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    trainer.Step();
  }
  const double seconds = ProcessorSeconds() - start;
  const TangentHierarchy levels{ OneRings(surface.Mesh) };
  // The forward pass, and twice as many operations for the derivatives.
  const double operations = 3.0 * LatentDiffusionOperations(network, vertices, levels.Coarse.NumberOfVertices());
  const double rate = operations * static_cast<double>(state.iterations()) / seconds;
  state.counters["GFLOP"] = 1e-9 * operations;
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
  state.counters["OfProductRate"] = rate / ProductRate();
}

} // namespace
} // namespace surfsynth::bench

/// On one thread: OMP_NUM_THREADS=1.
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
  benchmark::RegisterBenchmark("LatentDiffusionStep/paper", [](benchmark::State& state) {
    bench::LatentDiffusionStep(state, LatentDiffusionOptions::Paper());
  })->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return EXIT_SUCCESS;
}
