// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/ComplexMlp.h"

namespace surfsynth
{

namespace
{
constexpr double Epsilon = 1e-8; // under the root, and in denominators and scales
}

ComplexLinearImpl::ComplexLinearImpl(const ComplexLinearOptions& options)
{
  const auto linear = torch::nn::LinearOptions(options.in(), options.out()).bias(false);
  this->Real = this->register_module("lin_real", torch::nn::Linear(linear));
  this->Imaginary = this->register_module("lin_imag", torch::nn::Linear(linear));
  if (options.nonlinear())
  {
    this->MagnitudeBias = this->register_parameter("mag_bias", torch::zeros({ options.out() }));
  }
}

ComplexTensor ComplexLinearImpl::forward(const ComplexTensor& z)
{
  const ComplexTensor product = { this->Real(z.Real) - this->Imaginary(z.Imaginary),
    this->Imaginary(z.Real) + this->Real(z.Imaginary) };
  if (!this->MagnitudeBias.defined())
  {
    return product;
  }
  const torch::Tensor modulus = torch::sqrt(product.Real.square() + product.Imaginary.square() + Epsilon);
  const torch::Tensor factor = torch::gelu(modulus + this->MagnitudeBias) / (modulus + Epsilon);
  return { product.Real * factor, product.Imaginary * factor };
}

torch::Tensor ComplexLinearImpl::Matrix() const
{
  const torch::Tensor real = this->Real->weight.t();
  const torch::Tensor imaginary = this->Imaginary->weight.t();
  return torch::cat({ torch::cat({ real, imaginary }, 1), torch::cat({ -imaginary, real }, 1) }, 0);
}

torch::Tensor ComplexLinearImpl::DivergenceMatrix() const
{
  return torch::cat({ this->Real->weight.t(), this->Imaginary->weight.t() }, 0);
}

ModulatorImpl::ModulatorImpl(std::int64_t width)
{
  this->PhaseAndScale = this->register_module("modulator",
    torch::nn::Sequential(torch::nn::Linear(width, width), torch::nn::GELU(), torch::nn::Linear(width, 2 * width)));
}

ComplexTensor ModulatorImpl::forward(const ComplexTensor& z, const torch::Tensor& faceFeatures)
{
  const torch::Tensor phaseAndScale = this->PhaseAndScale->forward(faceFeatures);
  const std::vector<torch::Tensor> parts = phaseAndScale.chunk(2, -1);
  const torch::Tensor& phase = parts[0];
  const torch::Tensor scale = torch::softplus(parts[1]) + Epsilon;
  const torch::Tensor cosine = torch::cos(phase) * scale;
  const torch::Tensor sine = torch::sin(phase) * scale;
  return { z.Real * cosine - z.Imaginary * sine, z.Real * sine + z.Imaginary * cosine };
}

ComplexMlpImpl::ComplexMlpImpl(const ComplexMlpOptions& options)
{
  this->Layers = this->register_module("layers", torch::nn::ModuleList());
  for (std::int64_t layer = 0; layer < options.layers(); ++layer)
  {
    const bool last = layer == options.layers() - 1;
    this->Layers->push_back(
      ComplexLinear(ComplexLinearOptions(options.width(), last ? options.out() : options.width()).nonlinear(!last)));
  }
  if (options.modulate())
  {
    this->Modulation = this->register_module("modulator", Modulator(options.width()));
  }
}

ComplexTensor ComplexMlpImpl::Modulated(const ComplexTensor& z, const torch::Tensor& faceFeatures)
{
  return this->Modulation ? this->Modulation(z, faceFeatures) : z;
}

ComplexMatrices ComplexMlpImpl::Matrices()
{
  ComplexMatrices matrices;
  if (this->Modulation)
  {
    matrices.Modulator = this->Modulation->Output()->weight.t();
    matrices.ModulatorBias = this->Modulation->Output()->bias;
  }
  std::vector<torch::Tensor> layers;
  std::vector<torch::Tensor> biases;
  for (std::size_t k = 0; k + 1 < this->Layers->size(); ++k)
  {
    const ComplexLinearImpl& layer = *this->Layers[k]->as<ComplexLinear>();
    layers.push_back(layer.Matrix());
    biases.push_back(layer.Bias());
  }
  matrices.Layers = layers.empty() ? torch::empty({ 0, 0, 0 }) : torch::stack(layers);
  matrices.Biases = biases.empty() ? torch::empty({ 0, 0 }) : torch::stack(biases);
  return matrices;
}

torch::Tensor ComplexMlpImpl::ModulatorHidden(const torch::Tensor& vertexFeatures)
{
  return this->Modulation ? this->Modulation->Hidden(vertexFeatures) : torch::Tensor();
}

ComplexTensor ComplexMlpImpl::forward(const ComplexTensor& z, const torch::Tensor& faceFeatures)
{
  ComplexTensor features = this->Modulated(z, faceFeatures);
  for (const auto& layer : *this->Layers)
  {
    features = layer->as<ComplexLinear>()->forward(features);
  }
  return features;
}

} // namespace surfsynth
