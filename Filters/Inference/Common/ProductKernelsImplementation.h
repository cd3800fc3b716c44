// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the product kernels, included once for each instruction set by a file that defines SURFSYNTH_LANES (numbers of a
/// vector register), SURFSYNTH_VECTORS (registers across a block of the result) and SURFSYNTH_KERNELS (the table to define).
///
/// A block of the result stays in registers while k runs: each step reads one row of b and one number of a for each row of the
/// block. Includes no standard header but <cstdint>: see ActivationKernelsImplementation.h.
#pragma once

#include "Inference/Common/ProductKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;
constexpr int Lanes = SURFSYNTH_LANES;
/// Rows of a block: with their sums, a row of b and a number of a, six rows fill the registers.
constexpr int BlockRows = 6;
using Vector = float __attribute__((vector_size(4 * Lanes)));

/// A vector in memory at the address of any number.
struct __attribute__((packed, may_alias)) VectorInMemory
{
  Vector Value;
};

__attribute__((always_inline)) inline Vector Load(const float* from)
{
  return reinterpret_cast<const VectorInMemory*>(from)->Value;
}

/// Computes @p Rows rows and @p Vectors vectors of the result, from @p row and @p column on.
template <int Rows, int Vectors>
__attribute__((always_inline)) inline void MultiplyBlock(const SmallProduct& product, Size row, Size column)
{
  const float* a = product.A + row * product.RowStride;
  const float* b = product.B + column;
  float* const c = product.C + row * product.CStride + column;
  Vector sums[Rows][Vectors];
#pragma GCC unroll 8
  for (int i = 0; i < Rows; ++i)
  {
#pragma GCC unroll 8
    for (int j = 0; j < Vectors; ++j)
    {
      sums[i][j] = product.Accumulate ? Load(c + i * product.CStride + j * Lanes) : Vector{};
    }
  }
  for (Size k = 0; k < product.Inner; ++k, a += product.InnerStride, b += product.BStride)
  {
    Vector factors[Vectors];
#pragma GCC unroll 8
    for (int j = 0; j < Vectors; ++j)
    {
      factors[j] = Load(b + j * Lanes);
    }
#pragma GCC unroll 8
    for (int i = 0; i < Rows; ++i)
    {
#pragma GCC unroll 8
      for (int j = 0; j < Vectors; ++j)
      {
        sums[i][j] += a[i * product.RowStride] * factors[j];
      }
    }
  }
#pragma GCC unroll 8
  for (int i = 0; i < Rows; ++i)
  {
#pragma GCC unroll 8
    for (int j = 0; j < Vectors; ++j)
    {
      reinterpret_cast<VectorInMemory*>(c + i * product.CStride + j * Lanes)->Value = sums[i][j];
    }
  }
}

/// Computes all rows of @p Vectors vectors of the result.
template <int Vectors>
void MultiplyPanel(const SmallProduct& product, Size column)
{
  Size row = 0;
  for (; row + BlockRows <= product.Rows; row += BlockRows)
  {
    MultiplyBlock<BlockRows, Vectors>(product, row, column);
  }
  for (; row + 2 <= product.Rows; row += 2)
  {
    MultiplyBlock<2, Vectors>(product, row, column);
  }
  if (row < product.Rows)
  {
    MultiplyBlock<1, Vectors>(product, row, column);
  }
}

/// Computes what whole panels of @p Vectors vectors leave, by narrower ones.
template <int Vectors>
void MultiplyPanels(const SmallProduct& product, Size column)
{
  for (; column + Vectors * Lanes <= product.Columns; column += Vectors * Lanes)
  {
    MultiplyPanel<Vectors>(product, column);
  }
  if constexpr (Vectors > 1)
  {
    MultiplyPanels<Vectors - 1>(product, column);
  }
}

void MultiplySmall(const SmallProduct& product) { MultiplyPanels<SURFSYNTH_VECTORS>(product, 0); }
} // namespace

extern const ProductKernels SURFSYNTH_KERNELS = { Lanes, MultiplySmall };

} // namespace surfsynth
