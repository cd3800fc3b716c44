// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/VertexMlp.h"

namespace surfsynth
{

VertexNormImpl::VertexNormImpl(const VertexNormOptions& options)
  : MassWeighted(options.mass_weighted())
{
  this->Weight = this->register_parameter("weight", torch::ones({ options.channels() }));
  this->Bias = this->register_parameter("bias", torch::zeros({ options.channels() }));
}

torch::Tensor VertexNormImpl::forward(const MeshTensors& mesh, const torch::Tensor& signal)
{
  constexpr double epsilon = 1e-12;
  const auto mean = [&](const torch::Tensor& x) {
    return this->MassWeighted ? (x * mesh.VertexMass).sum(-2, true) / (mesh.VertexMass.sum() + epsilon)
                              : x.mean(-2, true);
  };
  const torch::Tensor centered = signal - mean(signal);
  const torch::Tensor variance = mean(centered.square());
  return centered / torch::sqrt(variance + epsilon) * this->Weight + this->Bias;
}

TwoLayerMlpImpl::TwoLayerMlpImpl(std::int64_t inputs, std::int64_t width, double dropout)
{
  this->Layers = this->register_module("layers",
    torch::nn::Sequential(torch::nn::Linear(inputs, width), torch::nn::GELU(), torch::nn::Dropout(dropout),
      torch::nn::Linear(width, width)));
}

VertexMlpImpl::VertexMlpImpl(const VertexMlpOptions& options)
  : Dropout(options.dropout())
{
  this->Scale1 = this->register_parameter("ls1", torch::ones({ options.width() }));
  this->Scale2 = this->register_parameter("ls2", torch::ones({ options.width() }));
  this->Mlp1 = this->register_module("mlp1", TwoLayerMlp(options.inputs(), options.width(), options.dropout()));
  this->Mlp2 = this->register_module("mlp2", TwoLayerMlp(options.width(), options.width(), options.dropout()));
  const auto norm = VertexNormOptions(options.width()).mass_weighted(options.mass_weighted_norm());
  if (options.normalize())
  {
    this->SolutionNorm = this->register_module("norm_pde", VertexNorm(norm));
  }
  if (options.normalize() && options.inner_products())
  {
    this->ProductNorm = this->register_module("norm_grad", VertexNorm(norm));
  }
}

VertexMlpWeights VertexMlpImpl::Weights()
{
  VertexMlpWeights weights;
  for (std::size_t k = 0; k < 4; ++k)
  {
    const torch::nn::LinearImpl& map = (k < 2 ? this->Mlp1 : this->Mlp2)->Map(k % 2);
    weights.Weight[k] = map.weight;
    weights.Bias[k] = map.bias;
  }
  weights.Scale[0] = this->Scale1;
  weights.Scale[1] = this->Scale2;
  return weights;
}

torch::Tensor VertexMlpImpl::forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& solved,
  const torch::Tensor& extra, const torch::Tensor& innerProducts)
{
  std::vector<torch::Tensor> inputs = { x, this->SolutionNorm ? this->SolutionNorm(mesh, solved) : solved };
  if (extra.defined())
  {
    inputs.push_back(extra);
  }
  if (innerProducts.defined())
  {
    inputs.push_back(this->ProductNorm ? this->ProductNorm(mesh, innerProducts) : innerProducts);
  }
  if (mesh.Tables && (this->Dropout == 0.0 || !this->is_training()))
  {
    return FusedVertexMlp(inputs, this->Weights());
  }
  const torch::Tensor y = x + this->Scale1 * this->Mlp1->forward(torch::cat(inputs, -1));
  return y + this->Scale2 * this->Mlp2->forward(y);
}

} // namespace surfsynth
