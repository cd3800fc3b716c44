// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of products of matrices that lie in the caches of a core. Private to the inference.
///
/// A library of linear algebra copies blocks of both factors first, to read them in order. A product of a tile of a hundred
/// rows by the weights of a layer does not pay that back: these loops read the factors where they are.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Sets c = a b, or c += a b. Element (i, k) of a is A[i * RowStride + k * InnerStride], so that transposes serve, too; rows of
/// b and c are BStride and CStride numbers apart.
struct SmallProduct
{
  const float* A;           ///< [Rows, Inner]
  std::int64_t RowStride;   ///< numbers from one row of a to the next
  std::int64_t InnerStride; ///< numbers from one column of a to the next
  const float* B;           ///< [Inner, Columns]
  std::int64_t BStride;     ///< numbers from one row of b to the next
  float* C;                 ///< [Rows, Columns]
  std::int64_t CStride;     ///< numbers from one row of c to the next
  std::int64_t Rows;        ///< of a and c
  std::int64_t Inner;       ///< columns of a, rows of b
  std::int64_t Columns;     ///< of b and c, a multiple of Lanes
  bool Accumulate;          ///< true to add to c
};

/// Kernels for one instruction set.
struct ProductKernels
{
  std::int64_t Lanes; ///< numbers of a vector
  void (*Multiply)(const SmallProduct& product);
};

/// Returns the kernels for CurrentInstructionSet(), or null where the BLAS serves better.
const ProductKernels* BestProductKernels();

#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const ProductKernels Avx2ProductKernels;   ///< for AVX2
extern const ProductKernels Avx512ProductKernels; ///< for AVX-512
#endif

} // namespace surfsynth
