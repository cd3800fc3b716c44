// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Convolutions of triangles after their matrix products, as single steps on the processor in float32, differentiable
/// twice. Private to Learning.
///
/// As expressions of LibTorch these are a dozen passes over memory, forward, backward and twice that for the derivatives of
/// gradients. Results are those up to rounding, and have the same bits for every number of threads.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <torch/torch.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Three rows of products that each triangle looks at, and for each row the triangles that look at it, always as many.
struct FaceSelection
{
  std::vector<std::int32_t> Rows;   ///< [F, 3]
  std::vector<std::int32_t> Faces;  ///< [rows, Uses], ascending
  std::vector<std::uint8_t> Places; ///< [rows, Uses], which of the rows of that triangle it is: 0, 1 or 2
  std::int64_t Uses = 0;            ///< number of triangles that look at a row

  /// Number of triangles, F.
  std::int64_t NumberOfFaces() const { return static_cast<std::int64_t>(this->Rows.size()) / 3; }
};

/// Tables of triangles that look at their neighbors, those of FaceNeighbors: each row is a triangle.
FaceSelection SelectNeighbors(const TriangleMatrix& neighbors);
/// Tables of @p faces triangles that look at their edges: row 3 f + k is edge k of triangle f.
FaceSelection SelectEdges(std::int64_t faces);

/// Parts of a convolution after its products.
struct FaceProducts
{
  /// [rows, C'] of edges, or [F, 2 C'] of triangles: what each gives its neighbors, then what it gives itself.
  torch::Tensor Products;
  torch::Tensor Bias; ///< [C']
  std::shared_ptr<const FaceSelection> Selection;
};

/// Computes bias + own product + largest of three products: [F, C'].
/// @throws InvalidInput from the computation of third derivatives.
torch::Tensor LargestProduct(const FaceProducts& products);

/// Computes LeakyReLU with slope 0.2 of the instance norm of that, (x - mean) / sqrt(variance + 1e-5): [F, C']. The bias
/// cancels: its derivative is 0.
/// @throws InvalidInput from the computation of third derivatives.
torch::Tensor NormalizedLargestProduct(const FaceProducts& products);

} // namespace surfsynth
