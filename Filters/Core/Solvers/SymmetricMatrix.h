// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Kinds of matrices, and checks of a matrix before it is solved. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

namespace surfsynth
{

/// Largest mean number of entries in a row of a matrix that is taken for that of a surface: six neighbors and the row
/// itself on average, where volumes have fourteen.
constexpr std::int64_t MostEntriesOfSurfaces = 9;
/// Fewest rows of a denser matrix that is ordered by nested dissection, with SURFACE_SYNTHESIS_CHOLMOD.
constexpr std::int64_t SmallestDissection = 10000;

/// Returns the matrix compressed, with rows ascending in each column.
SparseMatrix Sorted(SparseMatrix matrix);

/// @throws InvalidInput in the name of @p caller when the matrix is not square or has no row.
void RequireSquare(const SparseMatrix& matrix, const char* caller);

/// @param matrix square, as Sorted() returns it
/// @throws InvalidInput in the name of @p caller when an entry is not finite, or differs from its mirror image by more
/// than 1e-10 of itself and 1e-14 of the largest.
void RequireSymmetric(const SparseMatrix& matrix, const char* caller);

} // namespace surfsynth
