// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SupernodalAnalysis.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/NestedDissection.h"
#include "Core/Solvers/SymmetricMatrix.h"

#include <Eigen/CholmodSupport>

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

SupernodalAnalysis AnalyzeSupernodes(const SparseMatrix& matrix)
{
  std::vector<Index> dissection = IsDissected(matrix) ? NestedDissectionOrder(matrix) : std::vector<Index>();
  CholmodSession session(dissection.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN);
  cholmod_sparse lower = Eigen::viewAsCholmod(matrix.selfadjointView<Eigen::Lower>());
  const auto release = [&session](cholmod_factor* factor) { cholmod_free_factor(&factor, &session.Common); };
  Index* given = dissection.empty() ? nullptr : dissection.data();
  const std::unique_ptr<cholmod_factor, decltype(release)> factor(
    cholmod_analyze_p(&lower, given, nullptr, 0, &session.Common), release);
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
