// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Networks/InitialWeights.h"

#include "Core/Random/CounterUniforms.h"

#include <cmath>
#include <functional>
#include <numeric>
#include <string>

namespace surfsynth
{

namespace
{
constexpr double InitialLogDelta = -13.8; // of 1e-6

bool EndsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Initial value of all elements of a tensor, or NaN for random ones.
double ConstantOf(const std::string& name)
{
  if (EndsWith(name, "mag_bias") || EndsWith(name, "norm_pde.bias") || EndsWith(name, "norm_grad.bias"))
  {
    return 0.0;
  }
  if (EndsWith(name, ".ls1") || EndsWith(name, ".ls2") || EndsWith(name, "norm_pde.weight") ||
    EndsWith(name, "norm_grad.weight"))
  {
    return 1.0;
  }
  return EndsWith(name, "grad_scaler") ? 0.01 : std::nan("");
}

std::int64_t CountOf(const std::vector<std::int64_t>& shape)
{
  return std::accumulate(shape.begin(), shape.end(), std::int64_t(1), std::multiplies<std::int64_t>());
}

/// Bound of the random numbers of a tensor of a denoising network.
double DiffusionBound(const std::string& name, const std::vector<std::int64_t>& shape)
{
  const bool filter = name.find(".filter.") != std::string::npos;
  if (EndsWith(name, ".filter.radius") || EndsWith(name, ".filter.aligned") || EndsWith(name, ".filter.directed") ||
    EndsWith(name, ".filter.centroids"))
  {
    return std::sqrt(2.0); // three inputs
  }
  if (EndsWith(name, ".bias"))
  {
    return 1.0 / std::sqrt(static_cast<double>(shape.back()));
  }
  const std::int64_t inputs = shape.size() == 4 ? shape[2] * shape[3] : shape.back();
  return std::sqrt((filter ? 6.0 : 1.0) / static_cast<double>(inputs));
}

/// Initial value of all elements of a tensor of a denoising network, or NaN for random ones.
double DiffusionConstant(const std::string& name)
{
  if (EndsWith(name, ".convolution2.weight") || EndsWith(name, ".gains.weight") || name == "output.weight")
  {
    return 0.0;
  }
  return name == "latent_scale" ? 1.0 : EndsWith(name, ".log_delta") ? InitialLogDelta : std::nan("");
}
} // namespace

std::map<std::string, ModelTensor> InitialGeometricTextureTensors(
  const GeometricTextureOptions& options, bool discriminator, std::uint64_t seed)
{
  CheckOptions(options);
  const std::map<std::string, std::vector<std::int64_t>> shapes = ExpectedGeometricTextureTensors(
    options, discriminator);
  std::map<std::string, ModelTensor> tensors;
  NormalKey key;
  key.Seed = seed;
  key.Component = discriminator ? 1 : 0;
  for (const auto& [name, shape] : shapes)
  {
    // [C', C, 1] of weights; a bias [C'] has the inputs of its weights.
    const bool weight = shape.size() == 3;
    const std::int64_t inputs = shapes.at(name.substr(0, name.rfind('.')) + ".weight")[1];
    const double bound = 1.0 / std::sqrt(static_cast<double>(inputs));
    ModelTensor& tensor = tensors[name];
    tensor.Shape = shape;
    tensor.Values.resize(static_cast<std::size_t>(weight ? shape[0] * shape[1] : shape[0]));
    for (std::size_t k = 0; k < tensor.Values.size(); ++k)
    {
      tensor.Values[k] = static_cast<float>(bound * (2.0 * Uniform(key, static_cast<std::int64_t>(k)) - 1.0));
    }
    ++key.Sample;
  }
  return tensors;
}

PoissonNetModel InitialPoissonNet(const PoissonNetOptions& options, std::uint64_t seed)
{
  CheckOptions(options);
  PoissonNetModel model;
  model.Options = options;
  const std::map<std::string, std::vector<std::int64_t>> shapes = ExpectedTensors(options);
  NormalKey key;
  key.Seed = seed;
  for (const auto& [name, shape] : shapes)
  {
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    const bool matrix = shape.size() == 2;
    tensor.Values.resize(static_cast<std::size_t>(matrix ? shape[0] * shape[1] : shape[0]));
    const double constant = ConstantOf(name);
    // A bias has as many inputs as the matrix before it.
    const std::int64_t inputs = matrix || !std::isnan(constant)
      ? shape.back()
      : shapes.at(name.substr(0, name.rfind('.')) + ".weight")[1];
    const double bound = 1.0 / std::sqrt(static_cast<double>(inputs));
    for (std::size_t k = 0; k < tensor.Values.size(); ++k)
    {
      const double uniform = 2.0 * Uniform(key, static_cast<std::int64_t>(k)) - 1.0;
      tensor.Values[k] = static_cast<float>(std::isnan(constant) ? bound * uniform : constant);
    }
    ++key.Sample;
  }
  return model;
}

FieldLatentModel InitialFieldLatents(const FieldLatentOptions& options, std::uint64_t seed)
{
  CheckOptions(options);
  FieldLatentModel model;
  model.Options = options;
  const std::map<std::string, std::vector<std::int64_t>> shapes = ExpectedFieldLatentTensors(options);
  NormalKey key;
  key.Seed = seed;
  for (const auto& [name, shape] : shapes)
  {
    const std::int64_t count = CountOf(shape);
    const bool scale = EndsWith(name, ".scale");
    const bool random = !scale && !EndsWith(name, ".log_delta");
    // A bias has the inputs of its weights.
    const std::int64_t inputs = EndsWith(name, ".bias") ? shapes.at(name.substr(0, name.rfind('.')) + ".weight").back()
                                                        : shape.back();
    const double bound = 1.0 / std::sqrt(static_cast<double>(inputs));
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    for (std::int64_t k = 0; k < count; ++k)
    {
      const double constant = scale ? (k < count / 2 ? 1.0 : 0.0) : InitialLogDelta;
      tensor.Values.push_back(static_cast<float>(random ? bound * (2.0 * Uniform(key, k) - 1.0) : constant));
    }
    ++key.Sample;
  }
  return model;
}

LatentDiffusionModel InitialLatentDiffusion(const LatentDiffusionOptions& options, std::uint64_t seed)
{
  CheckOptions(options);
  LatentDiffusionModel model;
  model.Options = options;
  NormalKey key;
  key.Seed = seed;
  for (const auto& [name, shape] : ExpectedLatentDiffusionTensors(options))
  {
    const std::int64_t count = CountOf(shape);
    const bool scale = EndsWith(name, ".norm.scale");
    const double bound = DiffusionBound(name, shape);
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    for (std::int64_t k = 0; k < count; ++k)
    {
      const double constant = scale ? (k < count / 2 ? 1.0 : 0.0) : DiffusionConstant(name);
      const double random = bound * (2.0 * Uniform(key, k) - 1.0);
      tensor.Values.push_back(static_cast<float>(std::isnan(constant) ? random : constant));
    }
    ++key.Sample;
  }
  return model;
}

} // namespace surfsynth
