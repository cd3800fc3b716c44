// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What layers do between matrix products, as single differentiable steps on the processor in float32. Private to Learning.
///
/// As expressions of LibTorch these are chains of a dozen passes over memory, and sums at vertices run one row at a time;
/// together they take several times the products' time. Each step here reads its inputs once, forward and backward. They
/// have the same bits for every number of threads. Second derivatives are refused: they need the plain expressions.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <torch/torch.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// The faces around each vertex, with the weights of what goes back and forth.
struct FaceIncidence
{
  explicit FaceIncidence(const PoissonOperators& operators);

  std::int64_t NumberOfVertices() const { return static_cast<std::int64_t>(this->Offsets.size()) - 1; }
  std::int64_t NumberOfFaces() const { return this->Corners.rows(); }

  /// Weights of x, of y and of the mean for each entry.
  using Weights = std::array<std::vector<float>, 3>;

  TriangleMatrix Corners;            ///< [F, 3]
  FaceGradients BasisGradients;      ///< [F, 6]
  Eigen::VectorXf Areas;             ///< [F]
  std::vector<std::int32_t> Offsets; ///< [V + 1], of the entries of each vertex
  std::vector<std::int32_t> Faces;   ///< [3 F], the face of each entry
  Weights Transposed;                ///< of gradient and mean: hat gradients, and a third
  Weights Divergence;                ///< hat gradients times the face's area; none for the mean
  Weights Mean;                      ///< a third of the face's area over that around the vertex; none for x and y
};

/// True when the fused steps serve a tensor: float32 on the processor.
inline bool IsFused(const torch::Tensor& tensor) { return tensor.is_cpu() && tensor.scalar_type() == torch::kFloat32; }

/// Gradient (real, imaginary) and mean at the faces of a signal [..., V, C]: three tensors [..., F, C].
std::array<torch::Tensor, 3> FusedGatherFaces(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& signal);

/// G^T A g of a gradient [..., F, C]: [..., V, C].
torch::Tensor FusedDivergence(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& real, const torch::Tensor& imaginary);

/// Area-weighted mean of the faces around each vertex, [..., F, C] to [..., V, C].
torch::Tensor FusedVertexMean(const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& faceSignal);

/// See ComplexLinearOptions: the non-linearity of the modulus. Real and imaginary part.
std::array<torch::Tensor, 2> FusedComplexGelu(
  const torch::Tensor& real, const torch::Tensor& imaginary, const torch::Tensor& bias);

/// See Modulator: @p phaseAndScale [..., F, 2 C]. Real and imaginary part.
std::array<torch::Tensor, 2> FusedModulation(
  const torch::Tensor& phaseAndScale, const torch::Tensor& real, const torch::Tensor& imaginary);

} // namespace surfsynth
