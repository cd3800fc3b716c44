// SPDX-License-Identifier: BSD-3-Clause
#include "RandomLatentDiffusion.h"

#include "ExampleMeshes.h"

#include <cmath>

namespace surfsynth::test
{

namespace
{
bool EndsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}
} // namespace

LatentDiffusionOptions TinyLatentDiffusion()
{
  LatentDiffusionOptions options;
  options.LatentDimension = 2;
  options.Channels = 5;
  options.CoarseChannels = 18;
  options.InputBlocks = 1;
  options.CoarseBlocks = 2;
  options.OutputBlocks = 1;
  options.EmbeddingDimension = 6;
  options.NumberOfLabels = 3;
  options.Directed = true;
  options.TimeSteps = 100;
  return options;
}

LatentDiffusionModel RandomLatentDiffusion(const LatentDiffusionOptions& options, std::uint64_t seed)
{
  LatentDiffusionModel model;
  model.Options = options;
  model.Iterations = 7;
  seed *= 1000;
  for (const auto& [name, shape] : ExpectedLatentDiffusionTensors(options))
  {
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    std::int64_t count = 1;
    for (const std::int64_t extent : shape)
    {
      count *= extent;
    }
    // A convolution has [2, out, 8, in] weights.
    const std::int64_t inputs = shape.size() == 4 ? shape[2] * shape[3] : shape.back();
    const bool norm = EndsWith(name, ".norm.scale");
    const bool scale = name == "latent_scale";
    const bool gains = EndsWith(name, ".gains.weight"); // near 1, as of trained networks
    // Blocks add less to their inputs than random weights would: the network is conditioned as trained ones are.
    const bool last = EndsWith(name, ".convolution2.weight");
    const double random = std::sqrt(3.0 / static_cast<double>(inputs));
    const double factor = norm || scale ? 0.3
      : gains                           ? 0.1
      : EndsWith(name, ".log_delta")    ? 1.0
      : last                            ? 0.25 * random
                                        : random;
    ++seed;
    for (std::int64_t k = 0; k < count; ++k)
    {
      const double shift = scale || (norm && k < count / 2) ? 1.0 : 0.0;
      tensor.Values.push_back(static_cast<float>(shift + factor * Uniform(seed, static_cast<std::uint64_t>(k))));
    }
  }
  return model;
}

} // namespace surfsynth::test
