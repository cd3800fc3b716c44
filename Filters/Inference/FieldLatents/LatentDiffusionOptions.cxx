// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionOptions.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"

#include <cmath>
#include <tuple>

namespace surfsynth
{

namespace
{
auto AsTuple(const LatentDiffusionOptions& o)
{
  return std::tie(o.LatentDimension, o.Channels, o.CoarseChannels, o.InputBlocks, o.CoarseBlocks, o.OutputBlocks,
    o.EmbeddingDimension, o.NumberOfLabels, o.Directed, o.TimeSteps, o.FirstVariance, o.LastVariance, o.Target);
}

/// Least logarithm of the part of the variance of latents that the forward process may leave: its square can be divided by.
constexpr double LeastLogarithm = -300.0;

/// Logarithm of alpha of the last step, the product of 1 - variance of all steps.
double LogarithmOfSignal(const LatentDiffusionOptions& options)
{
  double sum = 0.0;
  for (std::int64_t step = 0; step < options.TimeSteps; ++step)
  {
    const double place = options.TimeSteps > 1 ? static_cast<double>(step) / static_cast<double>(options.TimeSteps - 1)
                                               : 0.0;
    sum += std::log1p(-(options.FirstVariance + place * (options.LastVariance - options.FirstVariance)));
  }
  return sum;
}

using Shapes = std::map<std::string, std::vector<std::int64_t>>;

void AddNeurons(Shapes& shapes, const std::string& name, std::int64_t inputs, std::int64_t outputs)
{
  for (int layer = 0; layer < 3; ++layer)
  {
    const std::string neuron = name + "." + std::to_string(layer);
    const std::int64_t width = layer == 0 ? inputs : outputs;
    shapes[neuron + ".norm.scale"] = { 2, width };
    shapes[neuron + ".norm.log_delta"] = { width };
    shapes[neuron + ".key.weight"] = { 2, outputs, width };
    shapes[neuron + ".query.weight"] = { 2, outputs, width };
  }
}

void AddConvolution(
  Shapes& shapes, const std::string& name, std::int64_t channels, bool embedded, const LatentDiffusionOptions& options)
{
  shapes[name + ".filter.radius"] = { FilterChannels };
  shapes[name + ".filter.aligned"] = { 2, FilterChannels };
  shapes[name + ".filter.bias"] = { FilterChannels };
  shapes[name + ".filter.hidden.weight"] = { FilterChannels, FilterChannels };
  shapes[name + ".filter.hidden.bias"] = { FilterChannels };
  shapes[name + ".weight"] = { 2, channels, FilterChannels, channels };
  if (embedded)
  {
    shapes[name + ".filter.centroids"] = { 2, FilterChannels };
    shapes[name + ".filter.embedding"] = { FilterChannels, options.EmbeddingDimension };
    if (options.Directed)
    {
      shapes[name + ".filter.directed"] = { 2, FilterChannels };
    }
  }
}

void AddBlock(Shapes& shapes, const std::string& name, std::int64_t inputs, std::int64_t outputs,
  const LatentDiffusionOptions& options)
{
  if (inputs != outputs)
  {
    shapes[name + ".residual.weight"] = { 2, outputs, inputs };
  }
  AddNeurons(shapes, name + ".mlp1", inputs, outputs);
  AddConvolution(shapes, name + ".convolution1", outputs, false, options);
  AddNeurons(shapes, name + ".mlp2", outputs, outputs);
  AddConvolution(shapes, name + ".convolution2", outputs, true, options);
  shapes[name + ".gains.weight"] = { outputs, options.EmbeddingDimension };
}
} // namespace

std::int64_t InputVectors(const LatentDiffusionOptions& options)
{
  return options.LatentDimension + (options.Directed ? 2 : 1);
}

LatentDiffusionOptions LatentDiffusionOptions::Paper() { return {}; }

LatentDiffusionOptions LatentDiffusionOptions::Small()
{
  LatentDiffusionOptions options;
  options.Channels = 32;
  options.CoarseChannels = 48;
  options.InputBlocks = 1;
  options.CoarseBlocks = 2;
  options.OutputBlocks = 2;
  return options;
}

bool operator==(const LatentDiffusionOptions& a, const LatentDiffusionOptions& b) { return AsTuple(a) == AsTuple(b); }

std::string NameOf(DiffusionTarget target)
{
  return target == DiffusionTarget::Noise ? "noise" : target == DiffusionTarget::Data ? "data" : "velocity";
}

void CheckOptions(const LatentDiffusionOptions& options)
{
  const struct
  {
    const char* Name;
    std::int64_t Value;
    std::int64_t Minimum;
    std::int64_t Maximum;
  } ranges[] = { { "LatentDimension", options.LatentDimension, 1, 256 }, { "Channels", options.Channels, 1, 4096 },
    { "CoarseChannels", options.CoarseChannels, 1, 4096 }, { "InputBlocks", options.InputBlocks, 1, 64 },
    { "CoarseBlocks", options.CoarseBlocks, 1, 64 }, { "OutputBlocks", options.OutputBlocks, 1, 64 },
    { "EmbeddingDimension", options.EmbeddingDimension, 2, 4096 },
    { "NumberOfLabels", options.NumberOfLabels, 0, 65536 }, { "TimeSteps", options.TimeSteps, 1, 100000 } };
  for (const auto& range : ranges)
  {
    if (range.Value < range.Minimum || range.Value > range.Maximum)
    {
      throw InvalidInput(std::string("LatentDiffusionOptions: ") + range.Name + " is " + std::to_string(range.Value) +
        "; expected " + std::to_string(range.Minimum) + " to " + std::to_string(range.Maximum) + ".");
    }
  }
  if (options.EmbeddingDimension % 2 != 0)
  {
    throw InvalidInput("LatentDiffusionOptions: EmbeddingDimension is " + std::to_string(options.EmbeddingDimension) +
      "; expected an even number.");
  }
  if (!(options.FirstVariance > 0.0 && options.FirstVariance <= options.LastVariance && options.LastVariance < 1.0))
  {
    throw InvalidInput("LatentDiffusionOptions: the variances are " + FormatNumber(options.FirstVariance) + " and " +
      FormatNumber(options.LastVariance) + "; expected 0 < FirstVariance <= LastVariance < 1.");
  }
  const double logarithm = LogarithmOfSignal(options);
  if (logarithm < LeastLogarithm)
  {
    throw InvalidInput("LatentDiffusionOptions: variances of " + FormatNumber(options.FirstVariance) + " to " +
      FormatNumber(options.LastVariance) + " leave exp(" + FormatNumber(logarithm) +
      ") of the variance of the latents " + "after " + std::to_string(options.TimeSteps) +
      " steps; expected at least exp(" + FormatNumber(LeastLogarithm) + "): fewer steps or smaller variances.");
  }
}

Shapes ExpectedLatentDiffusionTensors(const LatentDiffusionOptions& options)
{
  const std::int64_t embedding = options.EmbeddingDimension;
  Shapes shapes;
  shapes["latent_scale"] = { options.LatentDimension };
  for (const char* layer : { "time.0", "time.2" })
  {
    shapes[std::string(layer) + ".weight"] = { embedding, embedding };
    shapes[std::string(layer) + ".bias"] = { embedding };
  }
  if (options.NumberOfLabels > 0)
  {
    shapes["labels.weight"] = { options.NumberOfLabels, embedding };
  }
  shapes["input.weight"] = { 2, options.Channels, InputVectors(options) };
  shapes["output.weight"] = { 2, options.LatentDimension, options.Channels };
  shapes["input.gains.weight"] = { options.Channels, embedding };
  shapes["output.gains.weight"] = { options.Channels, embedding };
  const auto add = [&](const char* part, std::int64_t blocks, std::int64_t inputs, std::int64_t outputs) {
    for (std::int64_t block = 0; block < blocks; ++block)
    {
      AddBlock(shapes, part + std::to_string(block), block == 0 ? inputs : outputs, outputs, options);
    }
  };
  add("input.", options.InputBlocks, options.Channels, options.Channels);
  add("coarse.", options.CoarseBlocks, options.Channels, options.CoarseChannels);
  add("output.", options.OutputBlocks, options.CoarseChannels + options.Channels, options.Channels);
  return shapes;
}

} // namespace surfsynth
