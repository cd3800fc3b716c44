// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Features of the rings of vertices around each vertex on tensors, differentiable in the positions. RingFeatures.h has
/// the same without torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/RingFeatures.h"
#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

#include <vector>

namespace surfsynth
{

/// Vertices of one ring around each of N centers; W is the size of the largest one. Rows are filled up with the center.
struct RingTable
{
  torch::Tensor Vertices; ///< [N, W] int64
  torch::Tensor Missing;  ///< [N, W] bool, true where there is no vertex
  torch::Tensor Counts;   ///< [N, 1], sizes of the rings; floating point
  torch::Tensor IsOwn;    ///< [N, 1, 1], 0 where there is no such ring and the one before stands for it, else 1
  torch::Tensor Lower;    ///< [N, 5] int64, places of the quartiles among the heights in ascending order, rounded down
  torch::Tensor Upper;    ///< [N, 5] int64, rounded up
  torch::Tensor Share;    ///< [N, 5], share of the upper one
};

/// Rings 1 to R around the vertices of a mesh, as tensors of ids on one device.
struct RingTables
{
  torch::Tensor Centers;        ///< [N] int64: vertices whose rings are whole, or, when there are none, that have any
  std::vector<RingTable> Rings; ///< [R]

  RingTables() = default;
  /// Builds the tables of @p mesh. A ring without vertices is the ring before it.
  /// @param rings R, 1 to MaximumRings
  /// @param options floating-point type and device.
  RingTables(const TriangleMesh& mesh, int rings, const torch::TensorOptions& options);

  /// The tables of some of the centers. @param rows int64
  RingTables Take(const torch::Tensor& rows) const;
};

/// Computes the features of ComputeRingFeatures(): [N, 6 R] from @p positions [V, 3]. The normals of the neighborhoods
/// are constants in the derivative.
torch::Tensor RingFeatureTensor(const FaceTables& faces, const RingTables& tables, const torch::Tensor& positions);

} // namespace surfsynth
