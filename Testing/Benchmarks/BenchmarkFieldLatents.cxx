// SPDX-License-Identifier: BSD-3-Clause
// Field latents: encoder, decoder and denoising network of the paper's sizes.
#include "BenchmarkMeshes.h"
#include "ProductRate.h"
#include "RandomFieldLatents.h"
#include "RandomLatentDiffusion.h"

#include "IO/Weights/InstalledModels.h"
#include "Inference/FieldLatents/FieldLatentDecoder.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/FieldLatentOperations.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"
#include "Inference/FieldLatents/LatentDiffusionSampler.h"

#include <algorithm>
#include <cstdint>
#include <memory>

namespace surfsynth::bench
{
namespace
{

/// Rate of counted operations per second of processor time, and that over ProductRate() in the same run. Processor time,
/// unlike that of the clock, leaves out other work of the machine.
void CountOperations(benchmark::State& state, double operations, double seconds)
{
  const double rate = operations * static_cast<double>(state.iterations()) / seconds;
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
  state.counters["OfProductRate"] = rate / ProductRate();
}

/// Rings of 64 samples, one for every hundredth vertex.
void FieldLatentEncode(benchmark::State& state, const TriangleMesh& mesh)
{
  const FieldLatentOptions options = FieldLatentOptions::Paper();
  const FieldLatentEncoder encoder(test::RandomFieldLatents(options));
  const std::int64_t vertices = std::max<std::int64_t>(8, mesh.NumberOfPoints() / 100);
  const FieldLatentRings rings = test::RandomRings(vertices, options.SamplesPerRing);
  PeakMemory memory;
  memory.Restart();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(encoder.Encode(rings).Mean.data());
  }
  const double seconds = ProcessorSeconds() - start;
  const double operations = EncoderOperations(options, options.SamplesPerRing);
  state.counters["GFLOPperVertex"] = 1e-9 * operations;
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
  CountOperations(state, operations * static_cast<double>(vertices), seconds);
}

/// A texel for every vertex.
void FieldLatentDecode(benchmark::State& state, const TriangleMesh& mesh)
{
  const FieldLatentOptions options = FieldLatentOptions::Paper();
  const FieldLatentDecoder decoder(test::RandomFieldLatents(options));
  const std::int64_t count = mesh.NumberOfPoints();
  const std::int64_t vertices = std::max<std::int64_t>(8, count / 25);
  const FieldLatentMatrix latents = test::RandomLatents(vertices, options.LatentDimension);
  const FieldLatentTexels texels = test::RandomTexels(count, vertices);
  PeakMemory memory;
  memory.Restart();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(decoder.Decode(latents, texels).data());
  }
  const double seconds = ProcessorSeconds() - start;
  state.counters["MFLOPperTexel"] = 1e-6 * DecoderOperations(options);
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
  CountOperations(state, DecoderOperations(options) * static_cast<double>(count), seconds);
}

/// One evaluation of the denoising network of the paper's sizes.
void LatentDiffusionEvaluate(benchmark::State& state, const TriangleMesh& mesh)
{
  const LatentDiffusionOptions options = LatentDiffusionOptions::Paper();
  const LatentDiffusionNetwork network(
    test::RandomLatentDiffusion(options), std::make_shared<TangentHierarchy>(OneRings(mesh)));
  const auto vertices = static_cast<std::int64_t>(mesh.NumberOfPoints());
  const auto coarse = static_cast<std::int64_t>(network.Surface().Centers.size());
  const FieldLatentMatrix latents = test::RandomLatents(vertices, options.LatentDimension);
  PeakMemory memory;
  memory.Restart();
  const double start = ProcessorSeconds();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(network.Evaluate(latents, 500.0).data());
  }
  const double seconds = ProcessorSeconds() - start;
  state.counters["CoarseShare"] = static_cast<double>(coarse) / static_cast<double>(vertices);
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
  CountOperations(state, LatentDiffusionOperations(options, vertices, coarse), seconds);
}

/// A sample of a shipped model in 50 steps, levels of the surface included.
void LatentDiffusionSample(benchmark::State& state, const TriangleMesh& mesh)
{
  const LatentDiffusionModel model = ReadLatentDiffusion(ExistingModelPath("wood"));
  const double start = ProcessorSeconds();
  std::int64_t coarse = 0;
  for ([[maybe_unused]] auto step : state)
  {
    const LatentDiffusionSampler sampler(model, OneRings(mesh));
    coarse = static_cast<std::int64_t>(sampler.Network().Surface().Centers.size());
    benchmark::DoNotOptimize(sampler.Sample({}).data());
  }
  const double seconds = ProcessorSeconds() - start;
  const LatentSampleRequest request;
  CountOperations(
    state, request.NumberOfSteps * LatentDiffusionOperations(model.Options, mesh.NumberOfPoints(), coarse), seconds);
}

/// Rings and coarser level of a surface.
void LatentDiffusionLevels(benchmark::State& state, const TriangleMesh& mesh)
{
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(TangentHierarchy(OneRings(mesh)).Centers.data());
  }
}

} // namespace

void RegisterFieldLatents()
{
  Register("FieldLatentEncode", FieldLatentEncode, Sizes("10000"));
  Register("FieldLatentDecode", FieldLatentDecode, Sizes("10000"));
  Register("LatentDiffusionLevels", LatentDiffusionLevels, Sizes("30000"));
  Register("LatentDiffusionEvaluate", LatentDiffusionEvaluate, Sizes("30000"));
  Register("LatentDiffusionSample", LatentDiffusionSample, Sizes("10000"));
}

} // namespace surfsynth::bench
