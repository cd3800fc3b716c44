// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parts of layers between matrix products, as single differentiable steps on the processor in float32. Private to
/// Learning.
///
/// As expressions of LibTorch these are chains of a dozen passes over memory, and sums at vertices run one row at a
/// time; together they take several times the products' time. Each step here reads its inputs once, forward and
/// backward. They have the same bits for every number of threads. Second derivatives are refused: they need the plain
/// expressions.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <torch/torch.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Faces around each vertex, with the weights of maps between faces and vertices. An entry is a face at a vertex.
struct FaceIncidence
{
  /// Builds the tables of a mesh.
  explicit FaceIncidence(const PoissonOperators& operators);

  /// Number of vertices, V.
  std::int64_t NumberOfVertices() const { return static_cast<std::int64_t>(this->Offsets.size()) - 1; }
  /// Number of faces, F.
  std::int64_t NumberOfFaces() const { return this->Corners.rows(); }

  /// Weights of x, of y and of the mean for each entry.
  using Weights = std::array<std::vector<float>, 3>;

  TriangleMatrix Corners;            ///< [F, 3], vertices of each face
  FaceGradients BasisGradients;      ///< [F, 6]
  Eigen::VectorXf Areas;             ///< [F], face areas
  std::vector<std::int32_t> Offsets; ///< [V + 1], first entry of each vertex
  std::vector<std::int32_t> Faces;   ///< [3 F], face of each entry
  Weights Transposed;                ///< transposes of gradient and mean: basis gradients, and a third
  Weights Divergence;                ///< basis gradients times the face's area; none for the mean
};

/// True when the fused steps serve a tensor: float32 on the processor.
inline bool IsFused(const torch::Tensor& tensor) { return tensor.is_cpu() && tensor.scalar_type() == torch::kFloat32; }

/// Computes gradient (real, imaginary) and mean at the faces of a signal [..., V, C]: three tensors [..., F, C].
std::array<torch::Tensor, 3> FusedGatherFaces(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& signal);

/// Computes G^T A g of a gradient [..., F, C]: [..., V, C].
torch::Tensor FusedDivergence(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& real, const torch::Tensor& imaginary);

} // namespace surfsynth
