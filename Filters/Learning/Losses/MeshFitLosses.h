// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Losses of the fit of a mesh to another one, level by level, before the training of a geometric texture: [Hertz2020],
/// section 4, with the published weights.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <torch/torch.h>

#include <array>
#include <cstdint>

namespace surfsynth
{

/// The triangles and edges of a mesh as tensors of ids.
struct FitTables
{
  torch::Tensor Triangles;   ///< [F, 3] int64
  torch::Tensor Edges;       ///< [E, 2] int64, each once, the lower id first
  torch::Tensor Valence;     ///< [V, 1], number of edges at each vertex, at least 1; floating point
  std::int64_t Vertices = 0; ///< number of vertices, V

  FitTables() = default;
  /// Builds the tables of @p mesh.
  /// @param options floating-point type and device.
  /// @throws InvalidInput when an id is out of range.
  FitTables(const TriangleMesh& mesh, const torch::TensorOptions& options);
};

/// Loss of the triangulation, and its terms; scalars.
struct TriangulationLoss
{
  torch::Tensor EdgeDeviation; ///< standard deviation of the edges' lengths, with E - 1
  torch::Tensor EdgeEntropy;   ///< mean over the triangles of sum p ln p, p the lengths of the edges over their sum
  torch::Tensor Roughness; ///< mean over the vertices of the L1 norm of their distance to the mean of their neighbours
  torch::Tensor Total;     ///< 5e-3 EdgeDeviation + 5e-4 EdgeEntropy + 0.01 Roughness
};
/// Computes the loss of a triangulation with @p positions [V, 3].
TriangulationLoss ComputeTriangulationLoss(const FitTables& tables, const torch::Tensor& positions);

/// Points on a surface.
struct SurfaceSamples
{
  torch::Tensor Faces;   ///< [N] int64
  torch::Tensor Weights; ///< [N, 3], barycentric coordinates
};

/// Positions of samples, and the unit normals of their triangles; differentiable in the positions.
struct SampledSurface
{
  torch::Tensor Points;  ///< [N, 3]
  torch::Tensor Normals; ///< [N, 3], 0 for triangles without area
};
/// Computes the samples of a surface with @p positions [V, 3].
SampledSurface EvaluateSamples(const FitTables& tables, const torch::Tensor& positions, const SurfaceSamples& samples);

/// Ids of the nearest samples of the other surface.
struct NearestSampleIds
{
  torch::Tensor OfSource; ///< [N] int64, for each sample of the source the nearest one of the target
  torch::Tensor OfTarget; ///< [M] int64, for each sample of the target the nearest one of the source
};

/// Loss of the distance between two surfaces, and its terms; scalars.
struct ChamferLoss
{
  /// Means over source and target of sqrt(d^2 + 1e-8), d the distance to the nearest sample of the other surface.
  std::array<torch::Tensor, 2> Distance;
  /// Minus the means over source and target of the dot product with the normal at that sample.
  std::array<torch::Tensor, 2> Normal;
  torch::Tensor Total; ///< 0.4 Distance[0] + 0.6 Distance[1] + 0.1 (Normal[0] + Normal[1])
};

/// Computes the Chamfer loss of two sampled surfaces.
/// @param publishedNormals compares sample k of the source with the normal at sample OfTarget[k] of the target, as the
/// published code does by mistake; both surfaces must then have the same number of samples.
ChamferLoss ComputeChamferLoss(const SampledSurface& source, const SampledSurface& target,
  const NearestSampleIds& nearest, bool publishedNormals = false);

} // namespace surfsynth
