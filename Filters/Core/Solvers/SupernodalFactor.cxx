// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SupernodalFactor.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numeric>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
  const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
  const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
  const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
}

namespace surfsynth
{

namespace
{
/// The update matrices of fronts that wait for their parents: square, lower triangle, column-major. Their memory is
/// used again and again, in sizes that are powers of two.
class UpdatePool
{
public:
  /// Memory for @p rows x @p rows numbers, with any values.
  LargeArray<double> Borrow(std::int64_t rows) { return this->Take(SizeClass(static_cast<std::size_t>(rows * rows))); }
  void Return(LargeArray<double> memory) { this->Idle[SizeClass(memory.size())].Return(std::move(memory)); }

private:
  static int SizeClass(std::size_t size)
  {
    int sizeClass = 0;
    while ((std::size_t(1) << sizeClass) < size)
    {
      ++sizeClass;
    }
    return sizeClass;
  }
  LargeArray<double> Take(int sizeClass)
  {
    LargeArray<double> memory = this->Idle[sizeClass].Borrow();
    return memory.size() > 0 ? std::move(memory) : LargeArray<double>(std::size_t(1) << sizeClass);
  }

  std::array<ScratchPool<LargeArray<double>>, 64> Idle;
};

/// One numeric factorisation: the state that its fronts share.
class Multifrontal
{
public:
  Multifrontal(const SupernodalAnalysis& analysis, const SparseMatrix& matrix, double* values)
    : Symbolic(analysis)
    , Matrix(matrix)
    , Values(values)
    , Updates(static_cast<std::size_t>(analysis.Supernodes()))
    , FirstChild(static_cast<std::size_t>(analysis.Supernodes()), -1)
    , NextSibling(static_cast<std::size_t>(analysis.Supernodes()), -1)
  {
    for (Index s = analysis.Supernodes(); s-- > 0;)
    {
      if (analysis.Parent[s] >= 0)
      {
        this->NextSibling[s] = this->FirstChild[analysis.Parent[s]];
        this->FirstChild[analysis.Parent[s]] = s;
      }
    }
  }

  /// Assembles and factors front @p s, whose children are done. @p place is scratch of length n. The blocks of a large
  /// front go to several threads where @p isAlone says that no other front is factored at the same time.
  void Factor(Index s, std::vector<Index>& place, bool isAlone)
  {
    Front front{ this->Symbolic.PanelRows(s), this->Symbolic.Columns(s), this->Values + this->Symbolic.ValueStart[s],
      nullptr, isAlone };
    LargeArray<double> update = front.Below() > 0 ? this->Pool.Borrow(front.Below()) : LargeArray<double>();
    front.Update = update.data();
    this->Assemble(s, front, place);

    int info = 0;
    dpotrf_("L", &front.Columns, front.Panel, &front.Rows, &info);
    if (info != 0)
    {
      throw SolverFailure("CholeskySolver: the matrix is not positive definite (pivot " +
        std::to_string(this->Symbolic.FirstColumn[s] + info) + " of " + std::to_string(this->Symbolic.Size) +
        " is not positive); expected a symmetric positive definite matrix. Needle triangles or a screening term that "
        "is tiny for the size of the mesh cause this.");
    }
    Eliminate(front);
    this->Updates[s] = std::move(update);
  }

private:
  struct Front
  {
    int Rows;
    int Columns;
    double* Panel;  ///< [Rows, Columns]
    double* Update; ///< [Below(), Below()], lower triangle
    bool IsAlone;

    int Below() const { return this->Rows - this->Columns; }
  };

  /// Calls task(first, count) for blocks that cover @p size rows or columns, the same ones for every number of threads.
  template <typename Task>
  static void ForBlocks(const Front& front, int size, const Task& task)
  {
    constexpr int BlockSize = 384;
    const int blocks = (size + BlockSize - 1) / BlockSize;
    const auto run = [&](std::int64_t k) {
      const int first = static_cast<int>(k) * BlockSize;
      task(first, std::min(BlockSize, size - first));
    };
    if (front.IsAlone && blocks > 1)
    {
      ParallelTasks(blocks, run);
      return;
    }
    for (int k = 0; k < blocks; ++k)
    {
      run(k);
    }
  }

  /// Divides the rows below by the triangle, and subtracts their products from the update matrix.
  static void Eliminate(const Front& front)
  {
    const double one = 1.0;
    const double minusOne = -1.0;
    const int below = front.Below();
    double* lower = front.Panel + front.Columns;
    ForBlocks(front, below, [&](int first, int count) {
      dtrsm_("R", "L", "T", "N", &count, &front.Columns, &one, front.Panel, &front.Rows, lower + first, &front.Rows);
    });
    ForBlocks(front, below, [&](int first, int count) {
      const int under = below - first - count;
      double* diagonal = front.Update + std::int64_t(first) * (below + 1);
      dsyrk_("L", "N", &count, &front.Columns, &minusOne, lower + first, &front.Rows, &one, diagonal, &below);
      if (under > 0)
      {
        dgemm_("N", "T", &under, &count, &front.Columns, &minusOne, lower + first + count, &front.Rows, lower + first,
          &front.Rows, &one, diagonal + count, &below);
      }
    });
  }

  /// Scatters the entries of A and the children's updates into the panel and the update matrix.
  void Assemble(Index s, const Front& front, std::vector<Index>& place)
  {
    const Index start = this->Symbolic.FirstColumn[s];
    const Index* ids = this->Symbolic.PanelRowIds(s);
    for (Index k = 0; k < front.Rows; ++k)
    {
      place[ids[k]] = k;
    }
    ForBlocks(front, front.Columns, [&](int first, int count) {
      std::fill_n(front.Panel + std::int64_t(first) * front.Rows, std::int64_t(count) * front.Rows, 0.0);
      for (Index column = first; column < first + count; ++column)
      {
        for (SparseMatrix::InnerIterator entry(this->Matrix, this->Symbolic.OldOfNew[start + column]); entry; ++entry)
        {
          const Index row = this->Symbolic.NewOfOld[entry.row()];
          if (row >= start + column)
          {
            front.Panel[std::int64_t(column) * front.Rows + place[row]] = entry.value();
          }
        }
      }
    });
    ForBlocks(front, front.Below(), [&](int first, int count) {
      for (std::int64_t column = first; column < first + count; ++column)
      {
        std::fill_n(front.Update + column * (front.Below() + 1), front.Below() - column, 0.0);
      }
    });
    for (Index child = this->FirstChild[s]; child >= 0; child = this->NextSibling[child])
    {
      this->ExtendAdd(child, front, place);
    }
  }

  void ExtendAdd(Index child, const Front& front, const std::vector<Index>& place)
  {
    const Index own = this->Symbolic.Columns(child);
    const Index size = this->Symbolic.PanelRows(child) - own;
    const Index* ids = this->Symbolic.PanelRowIds(child) + own;
    std::vector<Index> target(static_cast<std::size_t>(size));
    std::transform(ids, ids + size, target.begin(), [&](Index id) { return place[id]; });
    ForBlocks(front, size, [&](int first, int count) { // columns of the child go to different ones of the front
      const double* source = this->Updates[child].data() + std::int64_t(first) * size;
      for (Index b = first; b < first + count; ++b, source += size)
      {
        const Index column = target[b];
        double* destination = column < front.Columns
          ? front.Panel + std::int64_t(column) * front.Rows
          : front.Update + std::int64_t(column - front.Columns) * front.Below() - front.Columns;
        for (Index a = b; a < size; ++a)
        {
          destination[target[a]] += source[a];
        }
      }
    });
    if (size > 0)
    {
      this->Pool.Return(std::move(this->Updates[child]));
    }
  }

  const SupernodalAnalysis& Symbolic;
  const SparseMatrix& Matrix;
  double* Values;
  UpdatePool Pool;
  std::vector<LargeArray<double>> Updates;
  std::vector<Index> FirstChild;
  std::vector<Index> NextSibling;
};

/// Floating-point operations of each front, and the supernodes split into disjoint subtrees, each of at most a small
/// share of the work, and the rest above them. Independent of the number of threads.
struct TaskTree
{
  std::vector<Index> Roots; ///< of the subtrees, most expensive first
  std::vector<Index> First; ///< [S], lowest descendant: subtree of s is First[s] .. s
  std::vector<Index> Above; ///< supernodes above the subtrees, children first
  std::vector<double> Work; ///< [S], operations of the subtree
};

TaskTree SplitIntoSubtrees(const SupernodalAnalysis& analysis)
{
  constexpr double LargestShare = 1.0 / 64.0;
  const Index count = analysis.Supernodes();
  TaskTree tree;
  tree.First.resize(static_cast<std::size_t>(count));
  std::iota(tree.First.begin(), tree.First.end(), 0);
  tree.Work.assign(static_cast<std::size_t>(count), 0.0);
  double total = 0.0;
  for (Index s = 0; s < count; ++s)
  {
    const double rows = analysis.PanelRows(s);
    const double columns = analysis.Columns(s);
    const double own = columns * rows * rows;
    total += own;
    tree.Work[s] += own;
    if (analysis.Parent[s] >= 0)
    {
      tree.Work[analysis.Parent[s]] += tree.Work[s];
      tree.First[analysis.Parent[s]] = std::min(tree.First[analysis.Parent[s]], tree.First[s]);
    }
  }
  const auto small = [&](Index s) { return tree.Work[s] <= LargestShare * total; };
  for (Index s = 0; s < count; ++s)
  {
    if (!small(s))
    {
      tree.Above.push_back(s);
    }
    else if (analysis.Parent[s] < 0 || !small(analysis.Parent[s]))
    {
      tree.Roots.push_back(s);
    }
  }
  std::stable_sort(tree.Roots.begin(), tree.Roots.end(), [&](Index a, Index b) { return tree.Work[a] > tree.Work[b]; });
  return tree;
}
} // namespace

SupernodalFactor::SupernodalFactor(SupernodalAnalysis analysis, const SparseMatrix& matrix, const Progress& progress)
  : Symbolic(std::move(analysis))
  , Values(static_cast<std::size_t>(this->Symbolic.ValueStart.back() + PanelPadding))
  , InverseDiagonal(static_cast<std::size_t>(this->Symbolic.Size))
{
  std::fill_n(this->Values.data() + this->Symbolic.ValueStart.back(), PanelPadding, 0.0);
  const SingleThreadedBlas blas;
  const TaskTree tree = SplitIntoSubtrees(this->Symbolic);
  Multifrontal fronts(this->Symbolic, matrix, this->Values.data());
  ScratchPool<std::vector<Index>> scratch;
  const double total = std::accumulate(tree.Work.begin(), tree.Work.end(), 0.0,
    [&, s = 0](double sum, double work) mutable { return sum + (this->Symbolic.Parent[s++] < 0 ? work : 0.0); });
  double done = 0.0;
  std::mutex mutex;

  const auto runSubtree = [&](std::int64_t k) {
    std::vector<Index> place = scratch.Borrow();
    place.resize(static_cast<std::size_t>(this->Symbolic.Size));
    for (Index s = tree.First[tree.Roots[k]]; s <= tree.Roots[k]; ++s)
    {
      fronts.Factor(s, place, false);
    }
    scratch.Return(std::move(place));
    std::lock_guard<std::mutex> lock(mutex);
    done += tree.Work[tree.Roots[k]];
  };
  const auto report = [&] {
    double fraction;
    {
      std::lock_guard<std::mutex> lock(mutex);
      fraction = done / std::max(total, 1.0);
    }
    Report(progress, fraction);
  };
  ParallelTasks(static_cast<std::int64_t>(tree.Roots.size()), runSubtree, report);

  std::vector<Index> place = scratch.Borrow();
  place.resize(static_cast<std::size_t>(this->Symbolic.Size));
  for (const Index s : tree.Above)
  {
    fronts.Factor(s, place, true);
    const double rows = this->Symbolic.PanelRows(s);
    done += rows * rows * this->Symbolic.Columns(s);
    report();
  }
  for (Index s = 0; s < this->Symbolic.Supernodes(); ++s)
  {
    const double* panel = this->Values.data() + this->Symbolic.ValueStart[s];
    for (Index column = 0; column < this->Symbolic.Columns(s); ++column)
    {
      this->InverseDiagonal[this->Symbolic.FirstColumn[s] + column] = 1.0 /
        panel[std::int64_t(column) * (this->Symbolic.PanelRows(s) + 1)];
    }
  }
}

SupernodalPanel SupernodalFactor::Panel(Index s) const
{
  return { this->Symbolic.PanelRows(s), this->Symbolic.Columns(s), this->Symbolic.PanelRowIds(s),
    this->Values.data() + this->Symbolic.ValueStart[s], this->InverseDiagonal.data() + this->Symbolic.FirstColumn[s] };
}

namespace
{
/// Reports of passes over the factor, whenever an eighth of its entries has been read.
class PassReports
{
public:
  PassReports(const SupernodalFactor& factor, int passes, const Progress& progress)
    : Factor(factor)
    , Passes(passes)
    , Target(progress)
    , Interval(std::max<std::int64_t>(factor.Entries() / 8, 1))
  {}

  /// Counts the panel of supernode @p s.
  void Add(Index s)
  {
    const std::vector<std::int64_t>& start = this->Factor.Analysis().ValueStart;
    const std::int64_t before = this->Done / this->Interval;
    this->Done += start[s + 1] - start[s];
    if (this->Done / this->Interval != before)
    {
      Report(
        this->Target, static_cast<double>(this->Done) / static_cast<double>(this->Factor.Entries()) / this->Passes);
    }
  }

private:
  const SupernodalFactor& Factor;
  int Passes;
  const Progress& Target;
  std::int64_t Interval;
  std::int64_t Done = 0;
};
} // namespace

void SupernodalFactor::SolveInPlace(double* rightHandSides, std::int64_t count, const Progress& progress) const
{
  const SupernodalKernels& kernels = BestSupernodalKernels();
  PassReports reports(*this, 2, progress);
  for (Index s = 0; s < this->Symbolic.Supernodes(); ++s)
  {
    kernels.Forward(this->Panel(s), rightHandSides, count);
    reports.Add(s);
  }
  for (Index s = this->Symbolic.Supernodes(); s-- > 0;)
  {
    kernels.Backward(this->Panel(s), rightHandSides, count);
    reports.Add(s);
  }
}

void SupernodalFactor::SolveTransposedInPlace(
  double* rightHandSides, std::int64_t count, const Progress& progress) const
{
  const SupernodalKernels& kernels = BestSupernodalKernels();
  PassReports reports(*this, 1, progress);
  for (Index s = this->Symbolic.Supernodes(); s-- > 0;)
  {
    kernels.Backward(this->Panel(s), rightHandSides, count);
    reports.Add(s);
  }
}

double SupernodalFactor::LogDeterminant() const
{
  double sum = 0.0;
  for (const double inverse : this->InverseDiagonal)
  {
    sum -= std::log(inverse);
  }
  return 2.0 * sum;
}

} // namespace surfsynth
