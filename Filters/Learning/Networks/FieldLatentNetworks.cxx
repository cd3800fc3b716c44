// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Networks/FieldLatentNetworks.h"

#include "Core/Common/Errors.h"

#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::int64_t RGB = 3;

/// Product of complex tensors, real parts first in the last dimension.
torch::Tensor ComplexProduct(const torch::Tensor& a, const torch::Tensor& b)
{
  const std::vector<torch::Tensor> x = a.chunk(2, -1);
  const std::vector<torch::Tensor> y = b.chunk(2, -1);
  return torch::cat({ x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0] }, -1);
}

/// conj(a) b, likewise.
torch::Tensor ConjugateProduct(const torch::Tensor& a, const torch::Tensor& b)
{
  const std::vector<torch::Tensor> x = a.chunk(2, -1);
  const std::vector<torch::Tensor> y = b.chunk(2, -1);
  return torch::cat({ x[0] * y[0] + x[1] * y[1], x[0] * y[1] - x[1] * y[0] }, -1);
}
} // namespace

FieldLatentTransformerImpl::FieldLatentTransformerImpl(std::int64_t channels, std::int64_t heads)
{
  this->Norm1 = this->register_module("norm1", RingNorm(channels));
  this->Attention = this->register_module("attention", RingAttention(channels, heads));
  this->Norm2 = this->register_module("norm2", RingNorm(channels));
  this->Neuron1 = this->register_module("neuron1", VectorNeuron(channels));
  this->Neuron2 = this->register_module("neuron2", VectorNeuron(channels));
}

torch::Tensor FieldLatentTransformerImpl::forward(const torch::Tensor& x)
{
  const torch::Tensor attended = x + this->Attention(this->Norm1(x));
  return attended + this->Neuron2(this->Neuron1(this->Norm2(attended)));
}

torch::Tensor FieldLatentTransformerImpl::LastToken(const torch::Tensor& x)
{
  const torch::Tensor attended = x + this->Attention(this->Norm1(x));
  const torch::Tensor normalized = this->Norm2(attended).select(1, -1);
  return attended.select(1, -1) + this->Neuron2(this->Neuron1(normalized));
}

FieldLatentEncoderNetworkImpl::FieldLatentEncoderNetworkImpl(const FieldLatentOptions& options)
{
  const std::int64_t channels = options.Channels;
  this->Lift = this->register_module("lift", torch::nn::Linear(RGB, 2 * channels));
  this->Gather = this->register_module("gather", torch::nn::Linear(RGB, 2 * channels));
  this->Filter = this->register_module("filter",
    torch::nn::Sequential(
      torch::nn::Linear(1, channels), torch::nn::SiLU(), torch::nn::Linear(channels, 2 * channels)));
  this->Layers = this->register_module("layers", torch::nn::ModuleList());
  for (std::int64_t layer = 0; layer < options.EncoderLayers; ++layer)
  {
    this->Layers->push_back(FieldLatentTransformer(channels, options.Heads));
  }
  // The names of the heads have two parts.
  const auto mean = this->register_module("mean", std::make_shared<torch::nn::Module>());
  this->MeanNeuron = mean->register_module("neuron", VectorNeuron(channels));
  this->MeanOut = mean->register_module("out", ComplexMap(channels, options.LatentDimension));
  const auto deviation = this->register_module("deviation", std::make_shared<torch::nn::Module>());
  this->Product = deviation->register_module("product", ComplexMap(channels, channels));
  this->DeviationIn = deviation->register_module("0", torch::nn::Linear(2 * channels, channels));
  this->DeviationOut = deviation->register_module("2", torch::nn::Linear(channels, options.LatentDimension));
}

/// Equations 21 and 22: the features of samples and token, [R, N + 1, 2 C].
torch::Tensor FieldLatentEncoderNetworkImpl::Features(const torch::Tensor& logarithms, const torch::Tensor& colors)
{
  const torch::Tensor lifted = ComplexProduct(logarithms, this->Lift(colors));
  const torch::Tensor radii = logarithms.square().sum(-1, true).sqrt();
  const torch::Tensor gathered = ComplexProduct(logarithms, this->Gather(colors));
  const torch::Tensor token = ComplexProduct(gathered, this->Filter->forward(radii)).mean(1, true);
  return torch::cat({ lifted, token }, 1);
}

FieldLatentGaussians FieldLatentEncoderNetworkImpl::forward(
  const torch::Tensor& logarithms, const torch::Tensor& colors)
{
  torch::Tensor features = this->Features(logarithms, colors);
  const std::size_t last = this->Layers->size() - 1;
  for (std::size_t layer = 0; layer < last; ++layer)
  {
    features = this->Layers[layer]->as<FieldLatentTransformer>()->forward(features);
  }
  const torch::Tensor token = this->Layers[last]->as<FieldLatentTransformer>()->LastToken(features);
  const torch::Tensor mean = this->MeanOut(this->MeanNeuron(token));
  const torch::Tensor invariant = ConjugateProduct(this->Product(token), token);
  return { torch::stack(mean.chunk(2, -1), -1), this->DeviationOut(torch::silu(this->DeviationIn(invariant))) };
}

FieldLatentDecoderNetworkImpl::FieldLatentDecoderNetworkImpl(const FieldLatentOptions& options)
  : Coordinates(options.DecoderInputs() - options.NumberOfProducts())
{
  this->Layers = this->register_module("layers", torch::nn::ModuleList());
  for (std::int64_t layer = 0; layer <= options.DecoderLayers; ++layer)
  {
    this->Layers->push_back(torch::nn::Linear(layer == 0 ? options.DecoderInputs() : options.DecoderWidth,
      layer == options.DecoderLayers ? RGB : options.DecoderWidth));
  }
}

/// The layers after the first affine map.
torch::Tensor FieldLatentDecoderNetworkImpl::FieldOf(const torch::Tensor& first)
{
  torch::Tensor x = first;
  for (std::size_t layer = 1; layer < this->Layers->size(); ++layer)
  {
    x = this->Layers[layer]->as<torch::nn::Linear>()->forward(torch::silu(x));
  }
  return x;
}

torch::Tensor FieldLatentDecoderNetworkImpl::forward(const torch::Tensor& latents, const torch::Tensor& logarithms)
{
  const auto& first = *this->Layers[0]->as<torch::nn::Linear>();
  const torch::Tensor ofProducts = first.weight.narrow(1, this->Coordinates, first.weight.size(1) - this->Coordinates);
  const torch::Tensor share = torch::linear(LatentProducts(latents), ofProducts, first.bias).unsqueeze(1);
  const torch::Tensor coordinates = LatentCoordinates(latents, logarithms);
  return this->FieldOf(share + torch::linear(coordinates, first.weight.narrow(1, 0, this->Coordinates)));
}

torch::Tensor FieldLatentDecoderNetworkImpl::Blended(const torch::Tensor& latents, const torch::Tensor& barycentric)
{
  const torch::Tensor products = torch::matmul(barycentric, LatentProducts(latents));
  return this->FieldOf(this->Layers[0]->as<torch::nn::Linear>()->forward(products));
}

FieldLatentNetworkImpl::FieldLatentNetworkImpl(const FieldLatentOptions& options)
{
  CheckOptions(options);
  this->Encoder = this->register_module("encoder", FieldLatentEncoderNetwork(options));
  this->Decoder = this->register_module("decoder", FieldLatentDecoderNetwork(options));
}

torch::Tensor LatentProducts(const torch::Tensor& latents)
{
  const std::int64_t dimension = latents.size(-2);
  const torch::Tensor re = latents.select(-1, 0);
  const torch::Tensor im = latents.select(-1, 1);
  const torch::Tensor places = torch::triu_indices(
    dimension, dimension, 0, torch::TensorOptions(torch::kLong).device(latents.device()));
  const torch::Tensor a = re.index_select(-1, places[0]);
  const torch::Tensor b = im.index_select(-1, places[0]);
  const torch::Tensor c = re.index_select(-1, places[1]);
  const torch::Tensor d = im.index_select(-1, places[1]);
  return torch::cat({ a * c + b * d, b * c - a * d }, -1);
}

torch::Tensor LatentCoordinates(const torch::Tensor& latents, const torch::Tensor& logarithms)
{
  const torch::Tensor codes = torch::cat({ latents.select(-1, 0), latents.select(-1, 1) }, -1).unsqueeze(1);
  return ConjugateProduct(codes, logarithms);
}

FieldLatentNetwork MakeFieldLatentNetwork(const FieldLatentModel& model)
{
  CheckModel(model);
  FieldLatentNetwork network(model.Options);
  const torch::NoGradGuard noGradients;
  for (auto& parameter : network->named_parameters())
  {
    const ModelTensor& tensor = model.Tensors.at(parameter.key());
    parameter.value().copy_(torch::from_blob(const_cast<float*>(tensor.Values.data()), tensor.Shape, torch::kFloat32));
  }
  return network;
}

} // namespace surfsynth
