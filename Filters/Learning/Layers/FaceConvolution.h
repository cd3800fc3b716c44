// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Convolutions of triangles with the three triangles around them that do not depend on their order: "Deep Geometric
/// Texture Synthesis" (Hertz et al. 2020, section 3).
#pragma once

#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

#include <cstdint>

namespace surfsynth
{

struct FaceConvolutionOptions
{
  FaceConvolutionOptions(std::int64_t inputs, std::int64_t outputs)
    : inputs_(inputs)
    , outputs_(outputs)
  {}
  TORCH_ARG(std::int64_t, inputs);  ///< channels C of a triangle, or of an edge where of_edges
  TORCH_ARG(std::int64_t, outputs); ///< channels C'
  TORCH_ARG(bool, of_edges) = false;
};

/// Of triangles: y_f = max over the neighbours g of f of W [x_g, x_f] + b, with W [C', 2 C, 1].
/// Of edges:     y_f = max over the edges e of f of W x_e + b, with W [C', C, 1] and x_f = [x_0, x_1, x_2].
/// The maximum is taken of each channel. Parameters are named conv.weight and conv.bias as in the published code.
class FaceConvolutionImpl : public torch::nn::Module
{
public:
  explicit FaceConvolutionImpl(const FaceConvolutionOptions& options);
  /// @param features [F, C], or [F, 3 C] of edges. @returns [F, C']
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);

private:
  FaceConvolutionOptions Options;
  torch::nn::Conv1d Affine{ nullptr };
};
TORCH_MODULE(FaceConvolution);

/// A convolution, the norm of each channel over the triangles, LeakyReLU with slope 0.2. The convolution is named 0.
class FaceBlockImpl : public torch::nn::Module
{
public:
  explicit FaceBlockImpl(const FaceConvolutionOptions& options);
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);

private:
  FaceConvolution Convolution{ nullptr };
};
TORCH_MODULE(FaceBlock);

/// (x - mean) / sqrt(variance + 1e-5) of each channel of @p features [F, C]; the variance is biased.
torch::Tensor NormalisedOverFaces(const torch::Tensor& features);

} // namespace surfsynth
