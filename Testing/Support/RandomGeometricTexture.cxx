// SPDX-License-Identifier: BSD-3-Clause
#include "RandomGeometricTexture.h"

#include "ExampleMeshes.h"

#include <cmath>

namespace surfsynth::test
{

namespace
{
std::map<std::string, ModelTensor> RandomTensors(
  const GeometricTextureOptions& options, bool discriminator, std::uint64_t seed)
{
  std::map<std::string, ModelTensor> tensors;
  for (const auto& [name, shape] : ExpectedGeometricTextureTensors(options, discriminator))
  {
    const std::int64_t inputs = shape.size() == 3 ? shape[1] : shape[0];
    const bool last = !discriminator && name.find(".0.conv.") == std::string::npos;
    ModelTensor& tensor = tensors[name];
    tensor.Shape = shape;
    tensor.Values.resize(static_cast<std::size_t>(shape.size() == 3 ? shape[0] * inputs : inputs));
    ++seed;
    for (std::size_t k = 0; k < tensor.Values.size(); ++k)
    {
      tensor.Values[k] = static_cast<float>(
        (last ? 0.1 : 1.0) * Uniform(seed, k) / std::sqrt(static_cast<double>(inputs)));
    }
  }
  return tensors;
}
} // namespace

GeometricTextureOptions SmallGeometricTexture()
{
  GeometricTextureOptions options;
  options.Levels = 2;
  options.Layers = 5;
  options.StartChannels = 6;
  options.MinimumChannels = 6;
  options.MaximumChannels = 8;
  return options;
}

GeometricTextureModel RandomGeometricTexture(const GeometricTextureOptions& options, std::uint64_t seed)
{
  GeometricTextureModel model;
  model.Options = options;
  model.Name = "pebbles";
  model.Generator = RandomTensors(options, false, 1000 * seed);
  model.Discriminator = RandomTensors(options, true, 1000 * seed + 500);
  model.Template = Icosphere(0);
  model.ReconstructionNoise.resize(model.Template.NumberOfPoints(), 3);
  for (Eigen::Index k = 0; k < model.ReconstructionNoise.size(); ++k)
  {
    model.ReconstructionNoise.data()[k] = static_cast<float>(0.1 * Uniform(seed, static_cast<std::uint64_t>(k)));
  }
  return model;
}

} // namespace surfsynth::test
