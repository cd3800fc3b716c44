// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the supernodal kernels, included once for each instruction set by a file that defines
/// SURFSYNTH_VECTOR_DOUBLES (doubles in a vector register) and SURFSYNTH_KERNELS (name of the table to define).
///
/// Includes no standard header: inline functions of those would be compiled for the wide instruction set too, and the
/// linker might keep that copy for everybody.
#pragma once

#include "Core/Solvers/SupernodalKernels.h"

namespace surfsynth
{

namespace
{
constexpr int VectorDoubles = SURFSYNTH_VECTOR_DOUBLES;
typedef double Vector __attribute__((vector_size(VectorDoubles * sizeof(double)), aligned(8), may_alias));

/// Columns of the panel that are solved before their effect on the other rows is subtracted in one go.
constexpr int BlockColumns = 32;

/// A vector in memory at the address of any double. The struct says so: clang forgets the alignment of the typedef behind a
/// reference.
struct __attribute__((packed, may_alias)) VectorInMemory
{
  Vector Value;
};

Vector Load(const double* address) { return reinterpret_cast<const VectorInMemory*>(address)->Value; }

VectorInMemory& Store(double* address) { return *reinterpret_cast<VectorInMemory*>(address); }

/// Solves with the triangle of the panel's columns [first, last) for W vectors of right-hand sides.
template <int W>
void ForwardTriangle(const SupernodalPanel& panel, int first, int last, double* x, std::int64_t count)
{
  for (int j = first; j < last; ++j)
  {
    const double* column = panel.Values + std::int64_t(j) * panel.Rows;
    double* own = x + panel.RowIds[j] * count;
    Vector value[W];
    for (int w = 0; w < W; ++w)
    {
      value[w] = Load(own + w * VectorDoubles) * panel.InverseDiagonal[j];
      Store(own + w * VectorDoubles).Value = value[w];
    }
    for (int i = j + 1; i < last; ++i)
    {
      double* other = x + panel.RowIds[i] * count;
      for (int w = 0; w < W; ++w)
      {
        Store(other + w * VectorDoubles).Value -= column[i] * value[w];
      }
    }
  }
}

template <int W>
void BackwardTriangle(const SupernodalPanel& panel, int first, int last, double* x, std::int64_t count)
{
  for (int j = last - 1; j >= first; --j)
  {
    const double* column = panel.Values + std::int64_t(j) * panel.Rows;
    double* own = x + panel.RowIds[j] * count;
    Vector value[W];
    for (int w = 0; w < W; ++w)
    {
      value[w] = Load(own + w * VectorDoubles);
    }
    for (int i = last - 1; i > j; --i)
    {
      const double* other = x + panel.RowIds[i] * count;
      for (int w = 0; w < W; ++w)
      {
        value[w] -= column[i] * Load(other + w * VectorDoubles);
      }
    }
    for (int w = 0; w < W; ++w)
    {
      Store(own + w * VectorDoubles).Value = value[w] * panel.InverseDiagonal[j];
    }
  }
}

/// R rows from @p row on: minus the product of their panel entries in columns [first, last) with the solved rows.
template <int R, int W>
void SubtractFromRows(const SupernodalPanel& panel, int first, int last, int row, double* x, std::int64_t count)
{
  Vector sum[R][W] = {};
  const double* column = panel.Values + std::int64_t(first) * panel.Rows + row;
  for (int j = first; j < last; ++j, column += panel.Rows)
  {
    const double* solved = x + panel.RowIds[j] * count;
    Vector value[W];
    for (int w = 0; w < W; ++w)
    {
      value[w] = Load(solved + w * VectorDoubles);
    }
    for (int r = 0; r < R; ++r)
    {
      for (int w = 0; w < W; ++w)
      {
        sum[r][w] += column[r] * value[w];
      }
    }
  }
  for (int r = 0; r < R; ++r)
  {
    double* target = x + panel.RowIds[row + r] * count;
    for (int w = 0; w < W; ++w)
    {
      Store(target + w * VectorDoubles).Value -= sum[r][w];
    }
  }
}

/// R columns from @p j on: minus the product of their panel entries in rows [first, Rows) with those rows.
template <int R, int W>
void SubtractFromColumns(const SupernodalPanel& panel, int j, int first, double* x, std::int64_t count)
{
  Vector sum[R][W] = {};
  const double* column = panel.Values + std::int64_t(j) * panel.Rows;
  for (int i = first; i < panel.Rows; ++i)
  {
    const double* solved = x + panel.RowIds[i] * count;
    Vector value[W];
    for (int w = 0; w < W; ++w)
    {
      value[w] = Load(solved + w * VectorDoubles);
    }
    for (int r = 0; r < R; ++r)
    {
      for (int w = 0; w < W; ++w)
      {
        sum[r][w] += column[std::int64_t(r) * panel.Rows + i] * value[w];
      }
    }
  }
  for (int r = 0; r < R; ++r)
  {
    double* target = x + panel.RowIds[j + r] * count;
    for (int w = 0; w < W; ++w)
    {
      Store(target + w * VectorDoubles).Value -= sum[r][w];
    }
  }
}

int BlockEnd(const SupernodalPanel& panel, int first)
{
  return first + BlockColumns < panel.Columns ? first + BlockColumns : panel.Columns;
}

/// Rows or columns at a time after R of them: 4, then halves.
constexpr int Fewer(int count) { return count > 4 ? 4 : count / 2; }

/// SubtractFromRows for all rows from @p row on, R at a time and then fewer.
template <int R, int W>
void SubtractFromAllRows(const SupernodalPanel& panel, int first, int last, int row, double* x, std::int64_t count)
{
  for (; row + R <= panel.Rows; row += R)
  {
    SubtractFromRows<R, W>(panel, first, last, row, x, count);
  }
  if constexpr (R > 1)
  {
    SubtractFromAllRows<Fewer(R), W>(panel, first, last, row, x, count);
  }
}

/// SubtractFromColumns for the columns [j, last), R at a time and then fewer.
template <int R, int W>
void SubtractFromAllColumns(const SupernodalPanel& panel, int j, int last, double* x, std::int64_t count)
{
  const int below = last;
  for (; j + R <= last; j += R)
  {
    SubtractFromColumns<R, W>(panel, j, below, x, count);
  }
  if constexpr (R > 1)
  {
    SubtractFromAllColumns<Fewer(R), W>(panel, j, last, x, count);
  }
}

/// Solves with the columns [first, last) for W vectors of right-hand sides and subtracts their effect below, R rows at a
/// time, so that R x W sums and W values fit the registers.
struct ForwardTile
{
  template <int R, int W>
  static void Run(const SupernodalPanel& panel, int first, int last, double* x, std::int64_t count)
  {
    ForwardTriangle<W>(panel, first, last, x, count);
    SubtractFromAllRows<R, W>(panel, first, last, last, x, count);
  }
};

/// Subtracts the effect of the rows below, R columns at a time, and solves with the transpose.
struct BackwardTile
{
  template <int R, int W>
  static void Run(const SupernodalPanel& panel, int first, int last, double* x, std::int64_t count)
  {
    SubtractFromAllColumns<R, W>(panel, first, last, x, count);
    BackwardTriangle<W>(panel, first, last, x, count);
  }
};

/// ForwardTriangle for one right-hand side: the same operations on each number.
void ForwardTriangleOfOne(const SupernodalPanel& panel, int first, int last, double* x)
{
  double* own = x + panel.RowIds[0]; // those of the supernode's own columns are consecutive
  for (int j = first; j < last; ++j)
  {
    const double* column = panel.Values + std::int64_t(j) * panel.Rows;
    const double value = own[j] * panel.InverseDiagonal[j];
    own[j] = value;
    for (int i = j + 1; i < last; ++i)
    {
      own[i] -= column[i] * value;
    }
  }
}

void BackwardTriangleOfOne(const SupernodalPanel& panel, int first, int last, double* x)
{
  double* own = x + panel.RowIds[0];
  for (int j = last - 1; j >= first; --j)
  {
    const double* column = panel.Values + std::int64_t(j) * panel.Rows;
    double value = own[j];
    for (int i = last - 1; i > j; --i)
    {
      value -= column[i] * own[i];
    }
    own[j] = value * panel.InverseDiagonal[j];
  }
}

/// SubtractFromRows for one right-hand side, the rows [row, row + W vectors) side by side in vectors. Those from the end
/// of the panel on are read, up to PanelPadding values of what follows, and dropped.
template <int W>
void SubtractFromRowsOfOne(const SupernodalPanel& panel, int first, int last, int row, double* x)
{
  Vector sum[W] = {};
  const double* column = panel.Values + std::int64_t(first) * panel.Rows + row;
  const double* own = x + panel.RowIds[0];
  for (int j = first; j < last; ++j, column += panel.Rows)
  {
    for (int w = 0; w < W; ++w)
    {
      sum[w] += Load(column + w * VectorDoubles) * own[j];
    }
  }
  double sums[W * VectorDoubles];
  for (int w = 0; w < W; ++w)
  {
    Store(sums + w * VectorDoubles).Value = sum[w];
  }
  const int rows = row + W * VectorDoubles < panel.Rows ? W * VectorDoubles : panel.Rows - row;
  for (int r = 0; r < rows; ++r)
  {
    x[panel.RowIds[row + r]] -= sums[r];
  }
}

/// SubtractFromColumns for one right-hand side: R chains of additions at a time.
template <int R>
void SubtractFromColumnsOfOne(const SupernodalPanel& panel, int j, int first, double* x)
{
  double sum[R] = {};
  const double* column = panel.Values + std::int64_t(j) * panel.Rows;
  for (int i = first; i < panel.Rows; ++i)
  {
    const double value = x[panel.RowIds[i]];
    for (int r = 0; r < R; ++r)
    {
      sum[r] += column[std::int64_t(r) * panel.Rows + i] * value;
    }
  }
  for (int r = 0; r < R; ++r)
  {
    x[panel.RowIds[0] + j + r] -= sum[r];
  }
}

template <int R>
void SubtractFromAllColumnsOfOne(const SupernodalPanel& panel, int j, int last, double* x)
{
  const int below = last;
  for (; j + R <= last; j += R)
  {
    SubtractFromColumnsOfOne<R>(panel, j, below, x);
  }
  if constexpr (R > 1)
  {
    SubtractFromAllColumnsOfOne<R / 2>(panel, j, last, x);
  }
}

/// Asks for the memory @p distance values behind each value of the panel: solves for one right-hand side wait for memory,
/// and small panels in descending order are no stream that the processor foresees.
void Prefetch(const SupernodalPanel& panel, std::int64_t distance)
{
  constexpr std::int64_t CacheLine = 8;
  const std::int64_t size = std::int64_t(panel.Rows) * panel.Columns;
  const auto begin = reinterpret_cast<std::uintptr_t>(panel.Values);
  for (std::int64_t k = 0; k < size; k += CacheLine)
  {
    const auto offset = static_cast<std::uintptr_t>((k + distance) * std::int64_t(sizeof(double)));
    __builtin_prefetch(reinterpret_cast<const void*>(begin + offset));
  }
}

/// Values between the panel in use and the memory that is asked for.
constexpr std::int64_t PrefetchDistance = 2048;

void ForwardOne(const SupernodalPanel& panel, double* x)
{
  Prefetch(panel, PrefetchDistance);
  constexpr int Most = 16 / VectorDoubles;
  for (int first = 0; first < panel.Columns; first = BlockEnd(panel, first))
  {
    const int last = BlockEnd(panel, first);
    ForwardTriangleOfOne(panel, first, last, x);
    int row = last;
    for (; row + 8 < panel.Rows; row += 2 * 8)
    {
      SubtractFromRowsOfOne<Most>(panel, first, last, row, x);
    }
    if (row < panel.Rows)
    {
      SubtractFromRowsOfOne<Most / 2>(panel, first, last, row, x);
    }
  }
}

void BackwardOne(const SupernodalPanel& panel, double* x)
{
  Prefetch(panel, -PrefetchDistance);
  for (int first = (panel.Columns - 1) / BlockColumns * BlockColumns; first >= 0; first -= BlockColumns)
  {
    const int last = BlockEnd(panel, first);
    SubtractFromAllColumnsOfOne<8>(panel, first, last, x);
    BackwardTriangleOfOne(panel, first, last, x);
  }
}

/// Vectors in a tile of 8 right-hand sides, and rows in it: with 16 registers of 4 doubles 6 rows leave no one idle.
constexpr int Narrow = 8 / VectorDoubles;
constexpr int NarrowRows = VectorDoubles == 4 ? 6 : VectorDoubles;

/// The columns [first, last) for all right-hand sides, in tiles: the block stays in cache for all of them.
template <typename Tile>
void RunTiles(const SupernodalPanel& panel, int first, int last, double* x, std::int64_t count)
{
  std::int64_t done = 0;
#if SURFSYNTH_VECTOR_DOUBLES == 8
  for (; done + 32 <= count; done += 32)
  {
    Tile::template Run<6, 4>(panel, first, last, x + done, count);
  }
  for (; done + 16 <= count; done += 16)
  {
    Tile::template Run<8, 2>(panel, first, last, x + done, count);
  }
#endif
  for (; done < count; done += 8)
  {
    Tile::template Run<NarrowRows, Narrow>(panel, first, last, x + done, count);
  }
}

void Forward(const SupernodalPanel& panel, double* x, std::int64_t count)
{
  if (count == 1)
  {
    ForwardOne(panel, x);
    return;
  }
  for (int first = 0; first < panel.Columns; first = BlockEnd(panel, first))
  {
    RunTiles<ForwardTile>(panel, first, BlockEnd(panel, first), x, count);
  }
}

void Backward(const SupernodalPanel& panel, double* x, std::int64_t count)
{
  if (count == 1)
  {
    BackwardOne(panel, x);
    return;
  }
  for (int first = (panel.Columns - 1) / BlockColumns * BlockColumns; first >= 0; first -= BlockColumns)
  {
    RunTiles<BackwardTile>(panel, first, BlockEnd(panel, first), x, count);
  }
}
} // namespace

extern const SupernodalKernels SURFSYNTH_KERNELS = { Forward, Backward };

} // namespace surfsynth
