// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Symbolic half of a supernodal Cholesky factorisation [Chen2008]. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Fill-reducing order and supernodes of a symmetric matrix: columns that share their pattern below the diagonal are
/// stored together as one dense panel, whose first rows are the supernode's own columns.
struct SupernodalAnalysis
{
  Index Size = 0;                       ///< n
  std::vector<Index> OldOfNew;          ///< [n], row of the matrix at each place of the elimination order
  std::vector<Index> NewOfOld;          ///< [n], its inverse
  std::vector<Index> FirstColumn;       ///< [S + 1], columns FirstColumn[s] .. FirstColumn[s + 1) form supernode s
  std::vector<std::int64_t> RowStart;   ///< [S + 1], into Rows
  std::vector<Index> Rows;              ///< row ids of each panel, ascending, in elimination order
  std::vector<std::int64_t> ValueStart; ///< [S + 1], begin of each panel in the factor's values
  std::vector<Index> Parent;            ///< [S], the supernode that the panel's update goes to, -1 at a root

  /// Number of supernodes, S.
  Index Supernodes() const { return static_cast<Index>(this->FirstColumn.size()) - 1; }
  /// Number of columns of supernode @p s.
  Index Columns(Index s) const { return this->FirstColumn[s + 1] - this->FirstColumn[s]; }
  /// Number of rows of the panel of supernode @p s.
  Index PanelRows(Index s) const { return static_cast<Index>(this->RowStart[s + 1] - this->RowStart[s]); }
  /// First row id of the panel of supernode @p s.
  const Index* PanelRowIds(Index s) const { return this->Rows.data() + this->RowStart[s]; }
};

/// Whether AnalyzeSupernodes() orders by NestedDissectionOrder(): matrices that are denser than those of surfaces, from
/// the size on where the factorization saves what the ordering costs.
bool IsDissected(const SparseMatrix& matrix);

/// Orders by NestedDissectionOrder(), see IsDissected(), by WindowedMinimumDegreeOrder() from 50,000 rows on, else by CHOLMOD's
/// AMD [Amestoy1996], and finds the supernodes by CHOLMOD [Chen2008]. Children precede parents.
/// @param matrix compressed, with both triangles
/// @throws SolverFailure when the factor would have more than 2^31 entries; std::bad_alloc.
SupernodalAnalysis AnalyzeSupernodes(const SparseMatrix& matrix);

} // namespace surfsynth
