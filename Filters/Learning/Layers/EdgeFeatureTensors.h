// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Geometry of [Hertz2020], section 3, on tensors: features of triangles, displacements and subdivision, differentiable
/// in the positions. EdgeFeatures.h has the same without torch.
///
/// Tables depend on the triangles only and are constant. Gradients are sums in a fixed order: the same bits every time.
#pragma once

#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/EdgeFeatures.h"

#include <torch/torch.h>

#include <cstdint>
#include <memory>

namespace surfsynth
{

struct FaceSelection;

/// Neighbors of the triangles of a mesh, as tensors of ids on one device.
struct FaceTables
{
  torch::Tensor Triangles; ///< [F, 3] int64
  torch::Tensor Neighbors; ///< [F, 3] int64, the triangle across each edge
  torch::Tensor Opposite;  ///< [F, 3] int64, the vertex of that triangle which is not on the edge
  torch::Tensor Sides;   ///< [F, 3, 1] floating point, -1 at a boundary edge, for half a turn of the own vertex, else 1
  torch::Tensor Corners; ///< [V, 1], number of triangles at each vertex, at least 1; floating point
  std::int64_t Vertices = 0; ///< number of vertices, V
  /// Tables of the fused convolutions of float32 on the processor; reset, the plain expressions are computed.
  std::shared_ptr<const FaceSelection> OfNeighbors;
  std::shared_ptr<const FaceSelection> OfEdges; ///< the same for the first convolution

  FaceTables() = default;
  /// Builds the tables of @p mesh.
  /// @param options floating-point type and device.
  /// @throws InvalidInput as ComputeFaceNeighbors().
  FaceTables(const TriangleMesh& mesh, const torch::TensorOptions& options);
};

/// Gathers rows of @p table [rows, C] by @p ids of any shape [...]: [..., C]. Differentiable twice.
torch::Tensor TakeRows(const torch::Tensor& table, const torch::Tensor& ids);

/// Adds up rows, the adjoint of TakeRows(): [rows, C], row k the sum of the rows of @p values [..., C] with id k in
/// @p ids [...].
torch::Tensor SumRows(const torch::Tensor& values, const torch::Tensor& ids, std::int64_t rows);

/// Computes the features of ComputeEdgeFeatures(): [F, 12] from @p positions [V, 3].
torch::Tensor EdgeFeatureTensor(const FaceTables& tables, const torch::Tensor& positions);

/// Computes the displacements of MeanCornerDisplacement(): [V, 3] from @p positions [V, 3] and @p local [F, 3], the
/// (a, b, c) of each triangle.
torch::Tensor CornerDisplacement(const FaceTables& tables, const torch::Tensor& positions, const torch::Tensor& local);

/// Ends of the edges that SubdivideAtMidpoints() puts vertices on, [E, 2] int64.
torch::Tensor ParentTensor(const SubdividedMesh& subdivided, const torch::Device& device);

/// Positions of the subdivided mesh in units of its own edges: 2 [positions; midpoints], [V + E, 3], so that the mean
/// edge length stays what it was.
torch::Tensor DoubledSubdivision(const torch::Tensor& positions, const torch::Tensor& parents);

} // namespace surfsynth
