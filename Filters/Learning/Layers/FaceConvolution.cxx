// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FaceConvolution.h"

#include "Learning/Layers/FaceSelection.h"
#include "Learning/Layers/FusedLayers.h"

#include <tuple>

namespace surfsynth
{

namespace
{
/// Maximum over the edges or neighbours of each triangle, [F, 3, C] to [F, C].
torch::Tensor LargestOfThree(const torch::Tensor& values) { return std::get<0>(values.max(1)); }
} // namespace

FaceConvolutionImpl::FaceConvolutionImpl(const FaceConvolutionOptions& options)
  : Options(options)
{
  const std::int64_t inputs = options.of_edges() ? options.inputs() : 2 * options.inputs();
  this->Affine = this->register_module(
    "conv", torch::nn::Conv1d(torch::nn::Conv1dOptions(inputs, options.outputs(), 1)));
}

std::optional<FaceProducts> FaceConvolutionImpl::Products(const FaceTables& tables, const torch::Tensor& features)
{
  if (!IsFused(features) || !tables.OfNeighbors)
  {
    return std::nullopt;
  }
  const torch::Tensor weight = this->Affine->weight.squeeze(-1);
  const std::int64_t channels = this->Options.inputs();
  if (this->Options.of_edges())
  {
    return FaceProducts{ features.reshape({ -1, channels }).mm(weight.t()), this->Affine->bias, tables.OfEdges };
  }
  const torch::Tensor both = torch::cat({ weight.narrow(1, 0, channels), weight.narrow(1, channels, channels) }, 0);
  return FaceProducts{ features.mm(both.t()), this->Affine->bias, tables.OfNeighbors };
}

torch::Tensor FaceConvolutionImpl::NormalizedAndActivated(const FaceTables& tables, const torch::Tensor& features)
{
  if (const std::optional<FaceProducts> products = this->Products(tables, features))
  {
    return NormalizedLargestProduct(*products);
  }
  constexpr double slope = 0.2;
  return torch::leaky_relu(NormalizedOverFaces(this->forward(tables, features)), slope);
}

torch::Tensor FaceConvolutionImpl::forward(const FaceTables& tables, const torch::Tensor& features)
{
  if (const std::optional<FaceProducts> products = this->Products(tables, features))
  {
    return LargestProduct(*products);
  }
  const torch::Tensor weight = this->Affine->weight.squeeze(-1);
  const std::int64_t channels = this->Options.inputs();
  if (this->Options.of_edges())
  {
    const torch::Tensor edges = features.reshape({ -1, 3, channels });
    return LargestOfThree(edges.matmul(weight.t())) + this->Affine->bias;
  }
  // W [x_g, x_f] + b = W_g x_g + (W_f x_f + b): each triangle is multiplied once, not once for each neighbour.
  const torch::Tensor asNeighbor = features.mm(weight.narrow(1, 0, channels).t());
  const torch::Tensor asItself = features.mm(weight.narrow(1, channels, channels).t()) + this->Affine->bias;
  return LargestOfThree(TakeRows(asNeighbor, tables.Neighbors)) + asItself;
}

FaceBlockImpl::FaceBlockImpl(const FaceConvolutionOptions& options)
{
  this->Convolution = this->register_module("0", FaceConvolution(options));
}

torch::Tensor FaceBlockImpl::forward(const FaceTables& tables, const torch::Tensor& features)
{
  return this->Convolution->NormalizedAndActivated(tables, features);
}

torch::Tensor NormalizedOverFaces(const torch::Tensor& features)
{
  constexpr double epsilon = 1e-5;
  const torch::Tensor centered = features - features.mean(0, true);
  return centered * torch::rsqrt(centered.square().mean(0, true) + epsilon);
}

} // namespace surfsynth
