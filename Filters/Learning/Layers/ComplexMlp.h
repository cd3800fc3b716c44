// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Layers on gradients [Maesumi2025]: complex numbers that rotate with the frame of their face. Complex-linear maps and
/// non-linearities of the modulus commute with rotations, so that results do not depend on the choice of frames.
#pragma once

#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/MeshTensors.h"

#include <torch/torch.h>

namespace surfsynth
{

/// Options of ComplexLinear.
struct ComplexLinearOptions
{
  /// @param in number of input channels
  /// @param out number of output channels
  ComplexLinearOptions(std::int64_t in, std::int64_t out)
    : in_(in)
    , out_(out)
  {}
  TORCH_ARG(std::int64_t, in);        ///< input channels
  TORCH_ARG(std::int64_t, out);       ///< output channels
  TORCH_ARG(bool, nonlinear) = false; ///< adds the non-linearity of the modulus
};

/// Complex-linear layer z -> W z, W complex without bias; when nonlinear followed by z -> z GELU(r + b) / (r + 1e-8)
/// with r = sqrt(|z|^2 + 1e-8) and one bias b for each channel. GELU is that of [Hendrycks2016].
class ComplexLinearImpl : public torch::nn::Module
{
public:
  /// Initialises W as torch::nn::Linear does, and b with 0.
  explicit ComplexLinearImpl(const ComplexLinearOptions& options);
  /// Maps [..., F, in] to [..., F, out].
  ComplexTensor forward(const ComplexTensor& z);
  /// W as a real matrix for rows of real parts, then imaginary parts: [2 in, 2 out].
  torch::Tensor Matrix() const;
  /// Map of the sums of FeatureSums to the divergence of the result: [2 in, out].
  torch::Tensor DivergenceMatrix() const;
  /// Bias of the modulus, [out], undefined when linear.
  const torch::Tensor& Bias() const { return this->MagnitudeBias; }

private:
  torch::nn::Linear Real{ nullptr };
  torch::nn::Linear Imaginary{ nullptr };
  torch::Tensor MagnitudeBias; ///< [out], undefined when linear
};
TORCH_MODULE(ComplexLinear);

/// Modulation z -> z exp(i p) (softplus(s) + 1e-8) with phases p and scales s from the features x of the face:
/// (p, s) = affine(GELU(affine(x))).
class ModulatorImpl : public torch::nn::Module
{
public:
  /// @param width number of channels
  explicit ModulatorImpl(std::int64_t width);
  /// Modulates gradients; returns [..., F, width].
  /// @param z [..., F, width]
  /// @param faceFeatures [..., F, width]
  ComplexTensor forward(const ComplexTensor& z, const torch::Tensor& faceFeatures);
  /// First affine map, which commutes with means: [..., width] to [..., width].
  torch::Tensor Hidden(const torch::Tensor& features) { return this->Map(0)->forward(features); }
  /// Second affine map.
  const torch::nn::LinearImpl* Output() { return this->Map(2); }

private:
  torch::nn::LinearImpl* Map(std::size_t k) { return this->PhaseAndScale[k]->as<torch::nn::Linear>(); }

  torch::nn::Sequential PhaseAndScale;
};
TORCH_MODULE(Modulator);

/// Options of ComplexMlp.
struct ComplexMlpOptions
{
  /// @param width number of input and hidden channels
  /// @param out number of output channels
  ComplexMlpOptions(std::int64_t width, std::int64_t out)
    : width_(width)
    , out_(out)
  {}
  TORCH_ARG(std::int64_t, width);      ///< input and hidden channels
  TORCH_ARG(std::int64_t, out);        ///< output channels
  TORCH_ARG(std::int64_t, layers) = 3; ///< number of layers, at least 1
  TORCH_ARG(bool, modulate) = true;    ///< begins with a Modulator
};

/// Complex MLP: a Modulator, then ComplexLinear layers of which all but the last are non-linear.
class ComplexMlpImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  explicit ComplexMlpImpl(const ComplexMlpOptions& options);
  /// Maps gradients to [..., F, out].
  /// @param z [..., F, width]
  /// @param faceFeatures [..., F, width]
  ComplexTensor forward(const ComplexTensor& z, const torch::Tensor& faceFeatures);
  /// Input of the first layer: the modulated gradients, [..., F, width].
  ComplexTensor Modulated(const ComplexTensor& z, const torch::Tensor& faceFeatures);
  /// Weights of all but the last layer for the fused steps.
  ComplexMatrices Matrices();
  /// First affine map of the modulator at the vertices; undefined without a modulator.
  torch::Tensor ModulatorHidden(const torch::Tensor& vertexFeatures);
  /// The last layer.
  ComplexLinearImpl& Last() { return *this->Layers[this->Layers->size() - 1]->as<ComplexLinear>(); }

private:
  Modulator Modulation{ nullptr };
  torch::nn::ModuleList Layers;
};
TORCH_MODULE(ComplexMlp);

} // namespace surfsynth
