// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SupernodalAnalysis.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/NestedDissection.h"
#include "Core/Solvers/SymmetricMatrix.h"
#include "Core/Solvers/WindowedMinimumDegree.h"

#include <Eigen/CholmodSupport>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>

namespace surfsynth
{

namespace
{
/// CHOLMOD's workspace and settings: an ordering, postordered, supernodal, silent.
class CholmodSession
{
public:
  explicit CholmodSession(int ordering)
  {
    cholmod_start(&this->Common);
    this->Common.nmethods = 1;
    this->Common.method[0].ordering = ordering;
    this->Common.postorder = 1;
    this->Common.supernodal = CHOLMOD_SUPERNODAL;
    this->Common.print = 0;
  }
  ~CholmodSession() { cholmod_finish(&this->Common); }
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;

  cholmod_common Common{};
};

/// The upper triangle of a symmetric matrix's pattern with rows and columns in another order. CHOLMOD takes half of the time to
/// analyse it that it takes where the order is an argument: then it transposes the matrix again and again.
class OrderedPattern
{
public:
  OrderedPattern(const SparseMatrix& matrix, const std::vector<Index>& order)
    : Starts(1, 0)
  {
    const Index* start = matrix.outerIndexPtr();
    const Index* rows = matrix.innerIndexPtr();
    std::vector<Index> newOfOld(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
    {
      newOfOld[order[k]] = static_cast<Index>(k);
    }
    this->Starts.reserve(order.size() + 1);
    this->Rows.reserve(order.empty() ? 0 : (order.size() + static_cast<std::size_t>(matrix.nonZeros())) / 2);
    for (const Index old : order)
    {
      const auto column = static_cast<Index>(this->Starts.size()) - 1;
      std::for_each(rows + start[old], rows + start[old + 1], [&](Index row) {
        if (newOfOld[row] <= column)
        {
          this->Rows.push_back(newOfOld[row]);
        }
      });
      this->Starts.push_back(static_cast<Index>(this->Rows.size()));
    }
  }

  /// A view for CHOLMOD; valid as long as this is.
  cholmod_sparse View()
  {
    cholmod_sparse view{};
    view.nrow = view.ncol = this->Starts.size() - 1;
    view.nzmax = this->Rows.size();
    view.p = this->Starts.data();
    view.i = this->Rows.data();
    view.stype = 1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_PATTERN;
    view.dtype = CHOLMOD_DOUBLE;
    view.packed = 1;
    return view;
  }

private:
  std::vector<Index> Starts;
  std::vector<Index> Rows;
};

/// The row after a panel's own columns belongs to the supernode that receives its update.
std::vector<Index> Parents(const SupernodalAnalysis& analysis)
{
  std::vector<Index> owner(static_cast<std::size_t>(analysis.Size));
  for (Index s = 0; s < analysis.Supernodes(); ++s)
  {
    for (Index column = analysis.FirstColumn[s]; column < analysis.FirstColumn[s + 1]; ++column)
    {
      owner[column] = s;
    }
  }
  std::vector<Index> parent(static_cast<std::size_t>(analysis.Supernodes()), -1);
  for (Index s = 0; s < analysis.Supernodes(); ++s)
  {
    const Index columns = analysis.Columns(s);
    if (analysis.PanelRows(s) > columns)
    {
      parent[s] = owner[analysis.PanelRowIds(s)[columns]];
    }
  }
  return parent;
}
} // namespace

bool IsDissected(const SparseMatrix& matrix)
{
  return matrix.rows() >= SmallestDissection && matrix.nonZeros() > MostEntriesOfSurfaces * matrix.rows();
}

namespace
{
/// An order of the library's own where it beats CHOLMOD's AMD, else empty: AMD runs in cache on smaller matrices.
std::vector<Index> OwnOrder(const SparseMatrix& matrix)
{
  constexpr Index SmallestWindowed = 50000;
  constexpr std::int64_t MostItems = std::numeric_limits<Index>::max() / 8; // lists grow by less
  if (IsDissected(matrix))
  {
    return NestedDissectionOrder(matrix);
  }
  const bool isWindowed = matrix.rows() >= SmallestWindowed && matrix.rows() + matrix.nonZeros() <= MostItems;
  return isWindowed ? WindowedMinimumDegreeOrder(matrix) : std::vector<Index>();
}
} // namespace

SupernodalAnalysis AnalyzeSupernodes(const SparseMatrix& matrix)
{
  const std::vector<Index> given = OwnOrder(matrix);
  OrderedPattern pattern(matrix, given);
  CholmodSession session(given.empty() ? CHOLMOD_AMD : CHOLMOD_NATURAL);
  cholmod_sparse view = given.empty() ? Eigen::viewAsCholmod(matrix.selfadjointView<Eigen::Lower>()) : pattern.View();
  const auto release = [&session](cholmod_factor* factor) { cholmod_free_factor(&factor, &session.Common); };
  const std::unique_ptr<cholmod_factor, decltype(release)> factor(cholmod_analyze(&view, &session.Common), release);
  if (session.Common.status == CHOLMOD_OUT_OF_MEMORY)
  {
    throw std::bad_alloc();
  }
  if (!factor || session.Common.status < CHOLMOD_OK || !factor->is_super)
  {
    throw SolverFailure("CholeskySolver: CHOLMOD cannot analyse a matrix of size " + std::to_string(matrix.rows()) +
      " (status " + std::to_string(session.Common.status) + "); the factor may exceed 2^31 entries.");
  }

  SupernodalAnalysis analysis;
  analysis.Size = static_cast<Index>(matrix.rows());
  const auto* order = static_cast<const Index*>(factor->Perm);
  analysis.OldOfNew.assign(order, order + analysis.Size);
  if (!given.empty())
  {
    std::transform(order, order + analysis.Size, analysis.OldOfNew.begin(), [&](Index k) { return given[k]; });
  }
  analysis.NewOfOld.resize(analysis.OldOfNew.size());
  for (Index k = 0; k < analysis.Size; ++k)
  {
    analysis.NewOfOld[analysis.OldOfNew[k]] = k;
  }
  const auto* super = static_cast<const Index*>(factor->super);
  const auto* rowStart = static_cast<const Index*>(factor->pi);
  const auto* rows = static_cast<const Index*>(factor->s);
  analysis.FirstColumn.assign(super, super + factor->nsuper + 1);
  analysis.RowStart.assign(rowStart, rowStart + factor->nsuper + 1);
  analysis.Rows.assign(rows, rows + analysis.RowStart.back());
  analysis.ValueStart.assign(1, 0);
  for (Index s = 0; s < analysis.Supernodes(); ++s)
  {
    analysis.ValueStart.push_back(
      analysis.ValueStart.back() + std::int64_t(analysis.PanelRows(s)) * analysis.Columns(s));
  }
  analysis.Parent = Parents(analysis);
  return analysis;
}

} // namespace surfsynth
