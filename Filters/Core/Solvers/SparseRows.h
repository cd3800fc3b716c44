// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sparse matrices stored by rows in large arrays, and the products that a multigrid hierarchy is made of. Private to
/// the solvers.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Operators/SurfaceOperators.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Sparse matrix stored by rows: the entries of row i are Start[i] ... Start[i + 1] - 1. One or both arrays of values.
struct SparseRows
{
  Index Rows = 0;           ///< number of rows
  Index Columns = 0;        ///< number of columns
  LargeArray<Index> Start;  ///< [Rows + 1]
  LargeArray<Index> Column; ///< [entries]
  LargeArray<double> Value; ///< [entries], or empty
  LargeArray<float> Single; ///< [entries], or empty

  /// Number of entries.
  std::int64_t Entries() const
  {
    return this->Start.size() > 0 ? this->Start[static_cast<std::size_t>(this->Rows)] : 0;
  }
  /// Bytes of all arrays.
  std::int64_t Bytes() const;
};

/// Orders the vertices of a matrix of symmetric pattern by breadth-first search, one component after the other: rows
/// that depend on each other lie close together in memory [Cuthill1969]. Linear time, one thread.
/// @return the vertex of each row, [V]
std::vector<Index> BreadthFirstOrder(const SparseMatrix& matrix, const Progress& progress);

/// The symmetric @p matrix with its rows and columns in @p order, in Value.
SparseRows Reordered(const SparseMatrix& matrix, const std::vector<Index>& order);

/// Transpose of a matrix with values in Single; columns ascend in each row. Linear time, one thread.
SparseRows Transposed(const SparseRows& matrix);

/// P^T S A S P in double precision, in Value, columns in order of discovery: in parallel over its rows.
/// @param matrix A, [V, V], values in Value
/// @param root the diagonal of S^-1, [V]; empty when S is the identity
/// @param prolongation P, [V, N], values in Single
/// @param restriction P^T, [N, V], values in Single
SparseRows GalerkinProduct(const SparseRows& matrix, const LargeArray<double>& root, const SparseRows& prolongation,
  const SparseRows& restriction, const Progress& progress);

} // namespace surfsynth
