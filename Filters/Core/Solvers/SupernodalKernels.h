// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Inner loops of triangular solves with one supernode, for one or many right-hand sides. Private to the solvers.
#pragma once

#include <cstdint>

namespace surfsynth
{

/// Values behind a panel that the kernels may read and drop; initialized memory.
constexpr int PanelPadding = 7;

/// One panel of a supernodal factor.
struct SupernodalPanel
{
  std::int32_t Rows;             ///< number of rows, those of the supernode's own columns first
  std::int32_t Columns;          ///< number of columns of the supernode
  const std::int32_t* RowIds;    ///< [Rows], rows of the right-hand sides
  const double* Values;          ///< [Rows, Columns], column-major
  const double* InverseDiagonal; ///< [Columns]
};

/// Triangular solves with one panel, on right-hand sides that are row-major with @p count columns, 1 or a multiple of 8.
/// Every column goes through the same operations in the same order whatever the count: vectors hold right-hand sides, or
/// the rows of a single one.
struct SupernodalKernels
{
  /// Solves for the supernode's rows and subtracts their effect from the rows below.
  void (*Forward)(const SupernodalPanel& panel, double* rightHandSides, std::int64_t count);
  /// Subtracts the effect of the rows below and solves with the transpose for the supernode's rows.
  void (*Backward)(const SupernodalPanel& panel, double* rightHandSides, std::int64_t count);
};

/// Returns the kernels for CurrentInstructionSet().
const SupernodalKernels& BestSupernodalKernels();

// The variants: the same source compiled for different instruction sets.
extern const SupernodalKernels GenericSupernodalKernels; ///< for every processor
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
extern const SupernodalKernels Avx2SupernodalKernels;   ///< for AVX2
extern const SupernodalKernels Avx512SupernodalKernels; ///< for AVX-512
#endif

} // namespace surfsynth
