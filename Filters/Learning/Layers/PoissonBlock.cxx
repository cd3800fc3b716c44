// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/PoissonBlock.h"

namespace surfsynth
{

namespace
{
/// Solves for the signal whose gradients come closest, with mean 0.
torch::Tensor Integrate(const MeshTensors& mesh, const ComplexTensor& gradients)
{
  return WithoutMean(mesh, SolvePoisson(mesh, IntegratedDivergence(mesh, gradients)));
}
} // namespace

PoissonBlockImpl::PoissonBlockImpl(const PoissonNetOptions& options)
{
  const std::int64_t width = options.Width;
  this->GradientMlp = this->register_module(
    "grad_mlp", ComplexMlp(ComplexMlpOptions(width, width).layers(options.ComplexLayers).modulate(options.Modulate)));
  if (options.InnerProducts)
  {
    this->GradientFeatures = this->register_module("grad_features", ComplexLinear(ComplexLinearOptions(width, width)));
    this->GradientScaler = this->register_parameter("grad_scaler", torch::full({ width }, 0.01));
  }
  const std::int64_t inputs = width * (2 + (options.ExtraFeatures > 0 ? 1 : 0) + (options.InnerProducts ? 1 : 0));
  this->Pointwise = this->register_module("vert_mlp",
    VertexMlp(VertexMlpOptions(width, inputs)
                .normalize(options.Normalize)
                .inner_products(options.InnerProducts)
                .mass_weighted_norm(options.MassWeightedNorm)
                .dropout(options.Dropout)));
}

torch::Tensor PoissonBlockImpl::forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra)
{
  const FaceSignal faces = AtFaces(mesh, x);
  const ComplexTensor& gradient = faces.Gradient;
  const ComplexTensor features = this->GradientMlp(gradient, faces.Mean);
  const torch::Tensor solved = Integrate(mesh, features);
  torch::Tensor products;
  if (this->GradientFeatures)
  {
    const ComplexTensor turned = this->GradientFeatures(features);
    const torch::Tensor dots = turned.Real * gradient.Real + turned.Imaginary * gradient.Imaginary;
    products = torch::tanh(VertexMean(mesh, dots) * this->GradientScaler);
  }
  return this->Pointwise(mesh, x, solved, extra, products);
}

GradientDomainHeadImpl::GradientDomainHeadImpl(const PoissonNetOptions& options)
{
  this->GradientMlp = this->register_module("grad_mlp",
    ComplexMlp(ComplexMlpOptions(options.Width, 3).layers(options.ComplexLayers).modulate(options.ModulateHead)));
}

IntegratedGradients GradientDomainHeadImpl::forward(
  const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& positions)
{
  const ComplexTensor own = FaceGradient(mesh, positions.detach());
  const FaceSignal faces = AtFaces(mesh, x);
  ComplexTensor gradients = this->GradientMlp(faces.Gradient, faces.Mean);
  gradients = { gradients.Real + own.Real, gradients.Imaginary + own.Imaginary };
  return { Integrate(mesh, gradients), Interleaved(gradients) };
}

} // namespace surfsynth
