// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parts of a PoissonNet [Maesumi2025] on the processor in float32, each a single differentiable step. Private to Learning.
///
/// The steps work on tiles of faces or vertices that stay in cache, and keep their inputs only: the backward pass computes
/// the rest again, one tile at a time, so that no array of all faces exists. With the values it then computes the slopes of
/// activations: an exponential serves both, and the way back through an activation is a product. A complex map is one real matrix product on
/// rows of real parts and imaginary parts. Results and derivatives have the same bits for every number of threads. Second
/// derivatives are refused.
#pragma once

#include "Inference/PoissonNet/FacePatches.h"

#include <torch/torch.h>

#include <memory>
#include <vector>

namespace surfsynth
{

/// A mesh in the form that the steps need.
struct PoissonTables
{
  /// Builds the tables. @param points [V, 3] of the mesh, or empty: patches are compact with them
  PoissonTables(const PoissonOperators& operators, const PointMatrix& points);

  /// Number of vertices, V.
  std::int64_t NumberOfVertices() const { return this->Mass.size(); }
  /// Number of faces, F.
  std::int64_t NumberOfFaces() const { return static_cast<std::int64_t>(this->Patches.FaceOfPlace.size()); }

  FacePatches Patches;                          ///< parts of the faces
  std::shared_ptr<const CholeskySolver> Solver; ///< of the Poisson equation
  Eigen::VectorXd Mass;                         ///< [V]
  std::vector<Index> Unused;                    ///< vertices of no face
};

/// Weights of a complex MLP as real matrices for rows of real parts, then imaginary parts: [inputs, outputs].
struct ComplexMatrices
{
  torch::Tensor Modulator;     ///< [W, 2 W], second affine map of the modulator; undefined without one
  torch::Tensor ModulatorBias; ///< [2 W]
  torch::Tensor Layers;        ///< [n, 2 W, 2 W], all layers but the last
  torch::Tensor Biases;        ///< [n, W]
};

/// Sums at vertices of the features of faces.
struct FeatureSums
{
  /// [..., V, 2 W]: sums over the faces around of area (bx re + by im), then of area (by re - bx im).
  torch::Tensor Divergence;
  /// [..., V, W]: sums of a third of the area times the dot products of mapped features and gradients, or undefined.
  torch::Tensor Dots;
};

/// Gradients of vertex features x through the modulation and the layers of @p mlp, added up at the vertices.
/// @param x [..., V, W]
/// @param hidden [..., V, W], first affine map of the modulator of x; undefined without a modulator
/// @param productMap [2 W, 2 W], map of the features for dot products, or undefined
FeatureSums FusedFeatureSums(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& x,
  const torch::Tensor& hidden, const ComplexMatrices& mlp, const torch::Tensor& productMap);

/// The same gradients through the layers and one more map, at the faces: [..., F, outputs].
/// @param last [2 W, outputs]
torch::Tensor FusedFaceFeatures(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& x,
  const torch::Tensor& hidden, const ComplexMatrices& mlp, const torch::Tensor& last);

/// Solution of the Poisson equation for right-hand sides [..., V, C], without its mass-weighted mean; 0 at unused vertices.
/// @throws InvalidInput when a number is not finite
torch::Tensor FusedPoissonSolve(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& rightHandSide);

/// Weights of the pointwise half of a block, see VertexMlp; maps as torch::nn::Linear has them.
struct VertexMlpWeights
{
  torch::Tensor Weight[4]; ///< [W, inputs W], then [W, W] each
  torch::Tensor Bias[4];   ///< [W] each
  torch::Tensor Scale[2];  ///< [W] each
};

/// Pointwise half of a block. @param inputs [..., V, W] each, the first of them x
torch::Tensor FusedVertexMlp(const std::vector<torch::Tensor>& inputs, const VertexMlpWeights& weights);

} // namespace surfsynth
