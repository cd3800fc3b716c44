// SPDX-License-Identifier: BSD-3-Clause
// Operators of the sources of a training under a limit of memory: the time to build them again beside that of an iteration, and
// whether their bytes are those that the process allocates.
#include "ExampleMeshes.h"

#include "Learning/Training/FlowMatchingTrainer.h"

#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace surfsynth::bench
{
namespace
{
constexpr double MiB = 1048576.0;

/// Ten tori of 2,500 points with two poses each.
SignalDataset Tori()
{
  SignalDataset dataset;
  for (int k = 0; k < 10; ++k)
  {
    SignalSource source;
    source.Mesh = test::Torus(50, 50);
    source.Samples.resize(2, source.Mesh.Points.size());
    const PointMatrix points = source.Mesh.Points;
    for (int n = 0; n < 2; ++n)
    {
      source.Samples.row(n) = (1.0F + 0.01F * static_cast<float>(n + k)) *
        Eigen::Map<const Eigen::RowVectorXd>(points.data(), points.size()).cast<float>();
      source.Samples.row(n).head(3 * (n + 1)) *= 1.01F;
    }
    dataset.Sources.push_back(source);
  }
  return dataset;
}

/// Bytes that the process has allocated; 0 where that is not known.
double Allocated()
{
#ifdef __GLIBC__
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
#else
  return 0.0;
#endif
}

/// Steps with the operators of one source at a time; BuildShare is the part of the time in which they are built.
void FlowMatchingSources(benchmark::State& state)
{
  FlowMatchingTrainingOptions options;
  options.Width = state.range(0);
  options.BatchSize = state.range(1);
  options.Device = TrainingDevice::CPU;
  options.SourceMemory = 0.0;
  const double start = Allocated();
  FlowMatchingTrainer trainer(Tori(), options);
  const double one = Allocated();
  options.SourceMemory = 8192.0;
  auto resident = std::make_unique<FlowMatchingTrainer>(Tori(), options);
  const double all = Allocated();
  const auto bytes = static_cast<double>(resident->SourceMemory().Bytes);
  const auto kept = static_cast<double>(trainer.SourceMemory().Bytes);
  resident.reset();
  const SourceMemoryUse before = trainer.SourceMemory();
  const auto begin = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    trainer.Step();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const SourceMemoryUse& after = trainer.SourceMemory();
  const double builds = static_cast<double>(after.Builds - before.Builds);
  state.counters["Builds"] = builds;
  state.counters["BuildMilliseconds"] = builds > 0.0 ? 1e3 * (after.BuildSeconds - before.BuildSeconds) / builds : 0.0;
  state.counters["BuildShare"] = (after.BuildSeconds - before.BuildSeconds) / seconds;
  state.counters["MiBPerSource"] = bytes / (10.0 * MiB);
  state.counters["PeakMiB"] = static_cast<double>(after.Peak) / MiB;
  state.counters["AllocatedPerCounted"] = ((all - one) - (one - start)) / (bytes - kept);
}
BENCHMARK(FlowMatchingSources)
  ->ArgNames({ "width", "batch" })
  ->Args({ 48, 1 })
  ->Args({ 64, 4 })
  ->Args({ 64, 32 })
  ->Unit(benchmark::kMillisecond);

} // namespace
} // namespace surfsynth::bench
