// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Smoothed aggregation of a symmetric matrix [Vanek1996]. Private to the solvers.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Solvers/SparseRows.h"

namespace surfsynth
{

/// A level of a hierarchy as its set-up needs it: the matrix scaled to a unit diagonal is S A S with S = diag(Scale).
struct AggregationInput
{
  const SparseRows& Matrix;         ///< A, values in Value
  const LargeArray<double>& Root;   ///< diagonal of S^-1, [V]; empty when A has a unit diagonal
  const LargeArray<double>& Smooth; ///< near-null vector of S A S, [V], positive: what must be interpolated exactly
};

/// Interpolation from aggregates.
struct AggregationResult
{
  SparseRows Prolongation;   ///< P, [V, N], values in Single; rows of vertices that relaxation alone solves are empty
  LargeArray<double> Smooth; ///< near-null vector of the coarse level, [N]: P times it is that of the fine one
};

/// Gathers vertices that depend on each other strongly into aggregates (greedily, in the order of rows, linear time, one
/// thread), and smooths piecewise constants by one step of Jacobi with the matrix without weak and positive entries, in
/// parallel. An entry is strong when it is negative and at least a fraction of the largest negative one of its row or of
/// its column. Vertices whose equation is dominated by its diagonal get no aggregate.
AggregationResult Aggregate(const AggregationInput& input, const Progress& progress);

} // namespace surfsynth
