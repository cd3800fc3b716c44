// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/PoissonBlock.h"

namespace surfsynth
{

namespace
{
/// Solves for the signal whose gradients come closest, with mean 0.
torch::Tensor Integrate(const MeshTensors& mesh, const ComplexTensor& gradients)
{
  const torch::Tensor divergence = IntegratedDivergence(mesh, gradients);
  return mesh.Tables ? FusedPoissonSolve(mesh.Tables, divergence) : WithoutMean(mesh, SolvePoisson(mesh, divergence));
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

PoissonBlockImpl::FromGradients PoissonBlockImpl::Plain(const MeshTensors& mesh, const torch::Tensor& x)
{
  const FaceSignal faces = AtFaces(mesh, x);
  const ComplexTensor& gradient = faces.Gradient;
  const ComplexTensor features = this->GradientMlp(gradient, faces.Mean);
  FromGradients found;
  found.Solved = Integrate(mesh, features);
  if (this->GradientFeatures)
  {
    const ComplexTensor turned = this->GradientFeatures(features);
    const torch::Tensor dots = turned.Real * gradient.Real + turned.Imaginary * gradient.Imaginary;
    found.Products = torch::tanh(VertexMean(mesh, dots) * this->GradientScaler);
  }
  return found;
}

/// The last layer is complex-linear: it maps sums at vertices, at half of the cost of maps at faces.
PoissonBlockImpl::FromGradients PoissonBlockImpl::Fused(const MeshTensors& mesh, const torch::Tensor& x)
{
  const ComplexLinearImpl& last = this->GradientMlp->Last();
  const torch::Tensor productMap = this->GradientFeatures
    ? torch::matmul(last.Matrix(), this->GradientFeatures->Matrix())
    : torch::Tensor();
  const FeatureSums sums = FusedFeatureSums(
    mesh.Tables, x, this->GradientMlp->ModulatorHidden(x), this->GradientMlp->Matrices(), productMap);
  FromGradients found;
  found.Solved = FusedPoissonSolve(mesh.Tables, torch::matmul(sums.Divergence, last.DivergenceMatrix()));
  if (this->GradientFeatures)
  {
    found.Products = torch::tanh(sums.Dots * mesh.InverseArea * this->GradientScaler);
  }
  return found;
}

torch::Tensor PoissonBlockImpl::forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra)
{
  const FromGradients found = mesh.Tables ? this->Fused(mesh, x) : this->Plain(mesh, x);
  return this->Pointwise(mesh, x, found.Solved, extra, found.Products);
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
  ComplexTensor gradients;
  if (mesh.Tables)
  {
    const std::vector<torch::Tensor> parts = FusedFaceFeatures(mesh.Tables, x, this->GradientMlp->ModulatorHidden(x),
      this->GradientMlp->Matrices(), this->GradientMlp->Last().Matrix())
                                               .chunk(2, -1);
    gradients = { parts[0], parts[1] };
  }
  else
  {
    const FaceSignal faces = AtFaces(mesh, x);
    gradients = this->GradientMlp(faces.Gradient, faces.Mean);
  }
  gradients = { gradients.Real + own.Real, gradients.Imaginary + own.Imaginary };
  return { Integrate(mesh, gradients), Interleaved(gradients) };
}

} // namespace surfsynth
