// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Convolutions of triangles with their three neighbours, independent of the order of these: [Hertz2020], section 3.
#pragma once

#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

#include <cstdint>
#include <optional>

namespace surfsynth
{

struct FaceProducts;

/// Options of FaceConvolution.
struct FaceConvolutionOptions
{
  /// @param inputs number of input channels
  /// @param outputs number of output channels
  FaceConvolutionOptions(std::int64_t inputs, std::int64_t outputs)
    : inputs_(inputs)
    , outputs_(outputs)
  {}
  TORCH_ARG(std::int64_t, inputs);   ///< channels C of a triangle, or of an edge with of_edges
  TORCH_ARG(std::int64_t, outputs);  ///< channels C'
  TORCH_ARG(bool, of_edges) = false; ///< features of the edges of triangles, not of triangles
};

/// Convolution over triangles. The maximum is that of each channel. Parameters are named conv.weight and conv.bias as
/// in the published code.
///   Of triangles: y_f = max over the neighbours g of f of W [x_g, x_f] + b, with W [C', 2 C, 1].
///   Of edges:     y_f = max over the edges e of f of W x_e + b, with W [C', C, 1] and x_f = [x_0, x_1, x_2].
class FaceConvolutionImpl : public torch::nn::Module
{
public:
  /// Initialises the parameters as torch::nn::Conv1d does.
  explicit FaceConvolutionImpl(const FaceConvolutionOptions& options);
  /// Computes the convolution, [F, C'].
  /// @param features [F, C], or [F, 3 C] of edges
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);
  /// Computes LeakyReLU with slope 0.2 of the instance norm of the convolution, [F, C'].
  torch::Tensor NormalizedAndActivated(const FaceTables& tables, const torch::Tensor& features);

private:
  /// Products of the fused steps; without value where these do not serve.
  std::optional<FaceProducts> Products(const FaceTables& tables, const torch::Tensor& features);

  FaceConvolutionOptions Options;
  torch::nn::Conv1d Affine{ nullptr };
};
TORCH_MODULE(FaceConvolution);

/// Block of a FaceConvolution, named 0, an instance norm over the triangles [Ulyanov2016], and LeakyReLU with slope
/// 0.2.
class FaceBlockImpl : public torch::nn::Module
{
public:
  /// @param options those of the convolution
  explicit FaceBlockImpl(const FaceConvolutionOptions& options);
  /// Computes the block, [F, C']; @p features as for FaceConvolution.
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);

private:
  FaceConvolution Convolution{ nullptr };
};
TORCH_MODULE(FaceBlock);

/// Instance norm (x - mean) / sqrt(variance + 1e-5) of each channel of @p features [F, C]; the variance is biased.
torch::Tensor NormalizedOverFaces(const torch::Tensor& features);

} // namespace surfsynth
