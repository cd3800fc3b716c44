// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers on gradients: complex numbers whose turn is the turn of the face's frame. Complex-linear maps and
/// non-linearities of the modulus commute with that turn, so that the choice of frames does not matter.
#pragma once

#include "Learning/Layers/MeshTensors.h"

#include <torch/torch.h>

namespace surfsynth
{

/// z -> W z, W complex without bias, and when Nonlinear then z -> z GELU(r + b) / (r + 1e-8) with
/// r = sqrt(|z|^2 + 1e-8) and one bias b for each channel.
struct ComplexLinearOptions
{
  ComplexLinearOptions(std::int64_t in, std::int64_t out)
    : in_(in)
    , out_(out)
  {}
  TORCH_ARG(std::int64_t, in);
  TORCH_ARG(std::int64_t, out);
  TORCH_ARG(bool, nonlinear) = false;
};

class ComplexLinearImpl : public torch::nn::Module
{
public:
  explicit ComplexLinearImpl(const ComplexLinearOptions& options);
  /// [..., F, in] to [..., F, out].
  ComplexTensor forward(const ComplexTensor& z);

private:
  torch::nn::Linear Real{ nullptr };
  torch::nn::Linear Imaginary{ nullptr };
  torch::Tensor MagnitudeBias; ///< [out], undefined when linear
};
TORCH_MODULE(ComplexLinear);

/// z -> z exp(i p) (softplus(s) + 1e-8) with phases p and scales s made from the features of the face:
/// (p, s) = affine(GELU(affine(x))).
class ModulatorImpl : public torch::nn::Module
{
public:
  explicit ModulatorImpl(std::int64_t width);
  /// @param z [..., F, width], @param faceFeatures [..., F, width]
  ComplexTensor forward(const ComplexTensor& z, const torch::Tensor& faceFeatures);

private:
  torch::nn::Sequential PhaseAndScale;
};
TORCH_MODULE(Modulator);

/// A modulation, and ComplexLinear layers of which all but the last are non-linear.
struct ComplexMlpOptions
{
  ComplexMlpOptions(std::int64_t width, std::int64_t out)
    : width_(width)
    , out_(out)
  {}
  TORCH_ARG(std::int64_t, width);
  TORCH_ARG(std::int64_t, out);
  TORCH_ARG(std::int64_t, layers) = 3;
  TORCH_ARG(bool, modulate) = true;
};

class ComplexMlpImpl : public torch::nn::Module
{
public:
  explicit ComplexMlpImpl(const ComplexMlpOptions& options);
  /// @param z [..., F, width], @param faceFeatures [..., F, width]; returns [..., F, out].
  ComplexTensor forward(const ComplexTensor& z, const torch::Tensor& faceFeatures);
  /// What the first layer sees.
  ComplexTensor Modulated(const ComplexTensor& z, const torch::Tensor& faceFeatures);

private:
  Modulator Modulation{ nullptr };
  torch::nn::ModuleList Layers;
};
TORCH_MODULE(ComplexMlp);

} // namespace surfsynth
