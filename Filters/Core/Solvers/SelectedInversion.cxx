// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SelectedInversion.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <algorithm>
#include <vector>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
  const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
}

namespace surfsynth
{

namespace
{
using Matrix = Eigen::MatrixXd;
using View = Eigen::Ref<const Matrix, 0, Eigen::OuterStride<>>;

/// Coefficients of a power series in e, truncated: one matrix for each power.
using Series = std::vector<Matrix>;

Series ZeroSeries(int powers, Eigen::Index rows, Eigen::Index columns)
{
  return Series(static_cast<std::size_t>(powers), Matrix::Zero(rows, columns));
}

/// target -= op(a) op(b), with the transpose where asked for.
void SubtractProduct(Matrix& target, const View& a, const View& b, bool transposeA = false, bool transposeB = false)
{
  const int rows = static_cast<int>(target.rows());
  const int columns = static_cast<int>(target.cols());
  const int inner = static_cast<int>(transposeA ? a.rows() : a.cols());
  const int strides[3] = { static_cast<int>(std::max<Eigen::Index>(a.outerStride(), 1)),
    static_cast<int>(std::max<Eigen::Index>(b.outerStride(), 1)),
    static_cast<int>(std::max<Eigen::Index>(target.outerStride(), 1)) };
  const double minusOne = -1.0;
  const double one = 1.0;
  if (rows > 0 && columns > 0 && inner > 0)
  {
    dgemm_(transposeA ? "T" : "N", transposeB ? "T" : "N", &rows, &columns, &inner, &minusOne, a.data(), &strides[0],
      b.data(), &strides[1], &one, target.data(), &strides[2]);
  }
}

void MirrorLower(Matrix& matrix) { matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose(); }

/// What the elimination of a supernode's columns J leaves for the way back: the inverse of the pivot block of the front
/// and the product of its rows R below with that inverse.
struct Pivot
{
  Series Inverse; ///< G = F_JJ^-1
  Series Ratio;   ///< Y = F_RJ G
};

/// Elimination from the leaves to the roots, and selected inversion from the roots to the leaves, on truncated series.
class SeriesInversion
{
public:
  SeriesInversion(
    const SupernodalAnalysis& analysis, const SparseMatrix& matrix, const Eigen::VectorXd& mass, int powers)
    : Symbolic(analysis)
    , A(matrix)
    , Mass(mass)
    , Powers(powers)
    , Children(static_cast<std::size_t>(analysis.Supernodes()))
    , Pivots(static_cast<std::size_t>(analysis.Supernodes()))
    , Updates(static_cast<std::size_t>(analysis.Supernodes()))
    , Inverses(static_cast<std::size_t>(analysis.Supernodes()))
    , Place(static_cast<std::size_t>(analysis.Size), 0)
  {
    for (Index s = 0; s < analysis.Supernodes(); ++s)
    {
      if (analysis.Parent[s] >= 0)
      {
        this->Children[analysis.Parent[s]].push_back(s);
      }
    }
  }

  /// Eliminates the columns of supernode @p s, whose children are done.
  void Eliminate(Index s)
  {
    const Index own = this->Symbolic.Columns(s);
    const Index below = this->Symbolic.PanelRows(s) - own;
    Series front = this->Assemble(s);
    Pivot& pivot = this->Pivots[s];
    pivot.Inverse = this->Invert(front, own);
    pivot.Ratio = ZeroSeries(this->Powers, below, own);
    Series& update = this->Updates[s];
    update = ZeroSeries(this->Powers, below, below);
    for (int k = 0; k < this->Powers; ++k)
    {
      for (int i = 0; i <= k; ++i)
      {
        SubtractProduct(pivot.Ratio[k], front[i].bottomLeftCorner(below, own), pivot.Inverse[k - i]);
      }
      pivot.Ratio[k] = -pivot.Ratio[k];
    }
    for (int k = 0; k < this->Powers; ++k)
    {
      update[k] = front[k].bottomRightCorner(below, below);
      for (int i = 0; i <= k; ++i)
      {
        SubtractProduct(update[k], pivot.Ratio[i], front[k - i].bottomLeftCorner(below, own), false, true);
      }
    }
  }

  /// Writes the diagonals of the inverse at the columns of supernode @p s, whose ancestors are done.
  void SelectInverse(Index s, Matrix& diagonals)
  {
    const Index own = this->Symbolic.Columns(s);
    const Index below = this->Symbolic.PanelRows(s) - own;
    const Series outer = this->InverseOfRows(s);
    const Pivot& pivot = this->Pivots[s];
    Series cross = ZeroSeries(this->Powers, below, own); // Z_RJ = -Z_RR Y
    Series block = pivot.Inverse;                        // Z_JJ = G - Y^T Z_RJ
    for (int k = 0; k < this->Powers; ++k)
    {
      for (int i = 0; i <= k; ++i)
      {
        SubtractProduct(cross[k], outer[i], pivot.Ratio[k - i]);
      }
    }
    for (int k = 0; k < this->Powers; ++k)
    {
      for (int i = 0; i <= k; ++i)
      {
        SubtractProduct(block[k], pivot.Ratio[i], cross[k - i], true);
      }
      const double sign = k % 2 == 0 ? 1.0 : -1.0;
      for (Index j = 0; j < own; ++j)
      {
        diagonals(this->Symbolic.OldOfNew[this->Symbolic.FirstColumn[s] + j], k) = sign * block[k](j, j);
      }
    }
    this->KeepInverse(s, block, cross, outer);
    this->Pivots[s] = Pivot();
  }

private:
  /// Entries of A + e M and the children's updates, the lower triangle.
  Series Assemble(Index s)
  {
    const Index rows = this->Symbolic.PanelRows(s);
    const Index first = this->Symbolic.FirstColumn[s];
    Series front = ZeroSeries(this->Powers, rows, rows);
    this->PlaceRows(s);
    for (Index column = 0; column < this->Symbolic.Columns(s); ++column)
    {
      const Index old = this->Symbolic.OldOfNew[first + column];
      for (SparseMatrix::InnerIterator entry(this->A, old); entry; ++entry)
      {
        const Index row = this->Symbolic.NewOfOld[entry.row()];
        if (row >= first + column)
        {
          front[0](this->Place[row], column) = entry.value();
        }
      }
      if (this->Powers > 1)
      {
        front[1](column, column) = this->Mass[old];
      }
    }
    for (const Index child : this->Children[s])
    {
      const std::vector<Index> target = this->PlacesOfRows(child);
      for (int k = 0; k < this->Powers; ++k)
      {
        const Matrix& update = this->Updates[child][k];
        for (Eigen::Index b = 0; b < update.cols(); ++b)
        {
          for (Eigen::Index a = b; a < update.rows(); ++a)
          {
            front[k](target[a], target[b]) += update(a, b);
          }
        }
      }
      this->Updates[child] = Series();
    }
    return front;
  }

  /// Inverse of the block of the first @p own rows and columns of @p front: G_0 = F_0^-1 and
  /// G_k = -G_0 (F_1 G_(k-1) + ... + F_k G_0).
  Series Invert(const Series& front, Index own) const
  {
    Series inverse = ZeroSeries(this->Powers, own, own);
    inverse[0] = front[0].topLeftCorner(own, own);
    const int size = own;
    int info = 0;
    dpotrf_("L", &size, inverse[0].data(), &size, &info);
    if (info == 0)
    {
      dpotri_("L", &size, inverse[0].data(), &size, &info);
    }
    if (info != 0)
    {
      throw SolverFailure("CholeskySolver: the matrix of size " + std::to_string(this->Symbolic.Size) +
        " is not positive definite to working precision; its inverse has no diagonal.");
    }
    MirrorLower(inverse[0]);
    for (int k = 1; k < this->Powers; ++k)
    {
      Matrix sum = Matrix::Zero(own, own);
      for (int i = 1; i <= k; ++i)
      {
        Matrix block = front[i].topLeftCorner(own, own);
        MirrorLower(block);
        SubtractProduct(sum, block, inverse[k - i]);
      }
      SubtractProduct(inverse[k], inverse[0], -sum);
      MirrorLower(inverse[k]);
    }
    return inverse;
  }

  /// Inverse at the rows below the panel of @p s, from the front of its parent.
  Series InverseOfRows(Index s)
  {
    const Index below = this->Symbolic.PanelRows(s) - this->Symbolic.Columns(s);
    Series outer = ZeroSeries(this->Powers, below, below);
    if (below == 0)
    {
      return outer;
    }
    const Index parent = this->Symbolic.Parent[s];
    this->PlaceRows(parent);
    const std::vector<Index> source = this->PlacesOfRows(s);
    for (int k = 0; k < this->Powers; ++k)
    {
      const Matrix& whole = this->Inverses[parent][k];
      for (Index b = 0; b < below; ++b)
      {
        for (Index a = 0; a < below; ++a)
        {
          outer[k](a, b) = whole(source[a], source[b]);
        }
      }
    }
    if (s == this->Children[parent].front()) // the last one on the way from the roots
    {
      this->Inverses[parent] = Series();
    }
    return outer;
  }

  /// Keeps the inverse at all rows of the panel of @p s for its children.
  void KeepInverse(Index s, const Series& block, const Series& cross, const Series& outer)
  {
    if (this->Children[s].empty())
    {
      return;
    }
    const Index own = this->Symbolic.Columns(s);
    const Index below = this->Symbolic.PanelRows(s) - own;
    for (int k = 0; k < this->Powers; ++k)
    {
      Matrix whole(own + below, own + below);
      whole.topLeftCorner(own, own) = block[k];
      whole.bottomLeftCorner(below, own) = cross[k];
      whole.topRightCorner(own, below) = cross[k].transpose();
      whole.bottomRightCorner(below, below) = outer[k];
      this->Inverses[s].push_back(std::move(whole));
    }
  }

  /// Enters the place of each row in the panel of @p s.
  void PlaceRows(Index s)
  {
    const Index* ids = this->Symbolic.PanelRowIds(s);
    for (Index k = 0; k < this->Symbolic.PanelRows(s); ++k)
    {
      this->Place[ids[k]] = k;
    }
  }

  /// Places of the rows below the panel of @p child in the panel that was entered last.
  std::vector<Index> PlacesOfRows(Index child) const
  {
    const Index* ids = this->Symbolic.PanelRowIds(child);
    std::vector<Index> places;
    for (Index k = this->Symbolic.Columns(child); k < this->Symbolic.PanelRows(child); ++k)
    {
      places.push_back(this->Place[ids[k]]);
    }
    return places;
  }

  const SupernodalAnalysis& Symbolic;
  const SparseMatrix& A;
  const Eigen::VectorXd& Mass;
  int Powers;
  std::vector<std::vector<Index>> Children; ///< ascending
  std::vector<Pivot> Pivots;
  std::vector<Series> Updates;  ///< of the fronts that wait for their parents
  std::vector<Series> Inverses; ///< of the fronts whose children are not all done
  std::vector<Index> Place;
};
} // namespace

Eigen::MatrixXd SelectedInverseDiagonals(const SupernodalAnalysis& analysis, const SparseMatrix& matrix,
  const Eigen::VectorXd& mass, int powers, const Progress& progress)
{
  const SingleThreadedBlas blas;
  SeriesInversion inversion(analysis, matrix, mass, powers);
  double total = 0.0;
  const auto work = [&](Index s) {
    const double rows = analysis.PanelRows(s);
    return rows * rows * analysis.Columns(s);
  };
  for (Index s = 0; s < analysis.Supernodes(); ++s)
  {
    total += 2.0 * work(s);
  }
  double done = 0.0;
  const auto report = [&](Index s) {
    done += work(s);
    Report(progress, std::min(done / total, 1.0));
  };
  for (Index s = 0; s < analysis.Supernodes(); ++s)
  {
    inversion.Eliminate(s);
    report(s);
  }
  Eigen::MatrixXd diagonals(analysis.Size, powers);
  for (Index s = analysis.Supernodes(); s-- > 0;)
  {
    inversion.SelectInverse(s, diagonals);
    report(s);
  }
  return diagonals;
}

} // namespace surfsynth
