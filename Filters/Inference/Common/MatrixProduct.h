// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Dense float32 matrix products on the calling thread. Private to the inference.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Computes c = a b, or c += a b when @p accumulate; all row-major and contiguous, a [rows, inner], b [inner, columns].
/// Uses the BLAS when there is one, which the caller keeps single-threaded (SingleThreadedBlas), else Eigen.
void Multiply(const float* a, const float* b, float* c, std::int64_t rows, std::int64_t inner, std::int64_t columns,
  bool accumulate = false);

/// Factor of a product: a block of a row-major matrix.
struct MatrixBlock
{
  const float* Data;       ///< first element
  std::int64_t Stride;     ///< numbers from one row in memory to the next
  bool Transposed = false; ///< true when the transpose of what is in memory is the factor
};

/// Computes c = a b, or c += a b when @p accumulate, with blocks of larger matrices: a [rows, inner], b [inner,
/// columns]. Rows of c are @p stride numbers apart.
void MultiplyBlocks(const MatrixBlock& a, const MatrixBlock& b, float* c, std::int64_t stride, std::int64_t rows,
  std::int64_t inner, std::int64_t columns, bool accumulate = false);

/// The same for factors that lie in the caches of a core, such as a tile of rows and the weights of a layer: no factor is copied
/// first. What ProductKernels do not compute (b transposed, columns beyond whole vectors) MultiplyBlocks() does.
void MultiplyInCache(const MatrixBlock& a, const MatrixBlock& b, float* c, std::int64_t stride, std::int64_t rows,
  std::int64_t inner, std::int64_t columns, bool accumulate = false);

} // namespace surfsynth
