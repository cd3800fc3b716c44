// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/CholeskySolver.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/SymmetricMatrix.h"

#ifdef SURFACE_SYNTHESIS_CHOLMOD
#include "Core/Solvers/SelectedInversion.h"
#include "Core/Solvers/SupernodalFactor.h"
#else
#include <Eigen/SparseCholesky>
#endif

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace surfsynth
{

namespace
{
#ifndef SURFACE_SYNTHESIS_CHOLMOD
/// Eigen's factor behind the same interface.
class SimplicialFactor
{
public:
  explicit SimplicialFactor(const SparseMatrix& matrix)
    : Rows(static_cast<std::size_t>(matrix.rows()))
  {
    std::iota(this->Rows.begin(), this->Rows.end(), 0);
    this->Solver.compute(matrix);
    if (this->Solver.info() != Eigen::Success)
    {
      throw SolverFailure("CholeskySolver: the matrix of size " + std::to_string(matrix.rows()) +
        " is not positive definite; expected a symmetric positive definite matrix. Needle triangles or a screening "
        "term that is tiny for the size of the mesh cause this.");
    }
  }
  void SolveInPlace(double* rightHandSides, std::int64_t count, const Progress& progress) const
  {
    Eigen::Map<RowMatrix> block(rightHandSides, static_cast<Eigen::Index>(this->Rows.size()), count);
    for (Eigen::Index column = 0; column < count; ++column)
    {
      const Eigen::VectorXd solution = this->Solver.solve(Eigen::VectorXd(block.col(column)));
      block.col(column) = solution;
      Report(progress, (column + 1.0) / count);
    }
  }
  void SolveTransposedInPlace(double* rightHandSides, std::int64_t count, const Progress& progress) const
  {
    Eigen::Map<RowMatrix> block(rightHandSides, static_cast<Eigen::Index>(this->Rows.size()), count);
    for (Eigen::Index column = 0; column < count; ++column)
    {
      // Rows are in the order of the matrix: entry v of a right-hand side belongs to the pivot of row v.
      const Eigen::VectorXd permuted = this->Solver.permutationP() * Eigen::VectorXd(block.col(column));
      const Eigen::VectorXd solution = this->Solver.matrixU().solve(permuted);
      block.col(column) = this->Solver.permutationPinv() * solution;
      Report(progress, (column + 1.0) / count);
    }
  }
  double LogDeterminant() const
  {
    return 2.0 * this->Solver.matrixL().nestedExpression().diagonal().array().log().sum();
  }
  const std::vector<Index>& Order() const { return this->Rows; }
  std::int64_t Entries() const { return this->Solver.matrixL().nestedExpression().nonZeros(); }

private:
  std::vector<Index> Rows;
  Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower> Solver;
};
#endif
} // namespace

class CholeskySolver::Internals
{
public:
  /// Requires right-hand sides of the shape that SolveOrderedInPlace() takes.
  void RequireOrdered(const Eigen::Ref<RowMatrix>& rightHandSides) const;

  std::shared_ptr<const SparseMatrix> Matrix;
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  std::unique_ptr<SupernodalFactor> Factor;
  const std::vector<Index>& Order() const { return this->Factor->Analysis().OldOfNew; }
  Eigen::MatrixXd InverseDiagonals(const Eigen::VectorXd& mass, int powers, const Progress& progress) const
  {
    return SelectedInverseDiagonals(this->Factor->Analysis(), *this->Matrix, mass, powers, progress);
  }
  void Compute(const Progress& progress)
  {
    // Ordering 100,000 vertices takes a tenth of a second, nested dissection one, and knows no progress; the numeric part
    // does.
    auto analysis = std::make_shared<SupernodalAnalysis>();
    const std::shared_ptr<const SparseMatrix> matrix = this->Matrix;
    RunCancellable([analysis, matrix] { *analysis = AnalyzeSupernodes(*matrix); },
      (IsDissected(*matrix) ? 8e-6 : 1e-6) * matrix->rows(), SubProgress(progress, 0.0, 0.4));
    this->Factor = std::make_unique<SupernodalFactor>(std::move(*analysis), *matrix, SubProgress(progress, 0.4, 1.0));
  }
#else
  std::unique_ptr<SimplicialFactor> Factor;
  const std::vector<Index>& Order() const { return this->Factor->Order(); }
  Eigen::MatrixXd InverseDiagonals(const Eigen::VectorXd& mass, int powers, const Progress& progress) const
  {
    const Eigen::Index size = mass.size();
    Eigen::MatrixXd diagonals(size, powers);
    for (Eigen::Index v = 0; v < size; ++v)
    {
      Eigen::VectorXd column = Eigen::VectorXd::Unit(size, v);
      for (int k = 0; k < powers; ++k)
      {
        this->Factor->SolveInPlace(column.data(), 1, {});
        diagonals(v, k) = column[v];
        column.array() *= mass.array();
      }
      Report(progress, (v + 1.0) / static_cast<double>(size));
    }
    return diagonals;
  }
  void Compute(const Progress& progress)
  {
    auto factor = std::make_shared<std::unique_ptr<SimplicialFactor>>();
    const std::shared_ptr<const SparseMatrix> matrix = this->Matrix;
    RunCancellable(
      [factor, matrix] { *factor = std::make_unique<SimplicialFactor>(*matrix); }, 1e-5 * matrix->rows(), progress);
    this->Factor = std::move(*factor);
  }
#endif
};

CholeskySolver::CholeskySolver(const SparseMatrix& matrix, const Progress& progress)
  : Impl(std::make_unique<Internals>())
{
  RequireSquare(matrix, "CholeskySolver");
  this->Impl->Matrix = std::make_shared<const SparseMatrix>(Sorted(matrix));
  RequireSymmetric(*this->Impl->Matrix, "CholeskySolver");
  this->Impl->Compute(progress);
  Report(progress, 1.0);
}

CholeskySolver::~CholeskySolver() = default;
CholeskySolver::CholeskySolver(CholeskySolver&&) noexcept = default;
CholeskySolver& CholeskySolver::operator=(CholeskySolver&&) noexcept = default;

Index CholeskySolver::Size() const { return static_cast<Index>(this->Impl->Matrix->rows()); }

std::int64_t CholeskySolver::FactorEntries() const { return this->Impl->Factor->Entries(); }

std::uint64_t CholeskySolver::EstimateMemory(std::int64_t rows, std::int64_t entries)
{
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  const double ofVolumes = rows < SmallestDissection ? 3.4 : 2.7;
#else
  const double ofVolumes = 3.4;
#endif
  const auto size = static_cast<double>(std::max<std::int64_t>(rows, 1));
  const double perRow = entries <= MostEntriesOfSurfaces * rows ? std::max(12.0 * std::log2(size) - 80.0, 10.0)
                                                                : std::max(ofVolumes * std::sqrt(size), 10.0);
  return static_cast<std::uint64_t>(size * std::min(perRow, 0.5 * (size + 1.0)) * sizeof(double));
}

const std::vector<Index>& CholeskySolver::Order() const { return this->Impl->Order(); }

void CholeskySolver::Internals::RequireOrdered(const Eigen::Ref<RowMatrix>& rightHandSides) const
{
  const bool fits = rightHandSides.cols() == 1 || rightHandSides.cols() % ColumnGranularity == 0;
  if (rightHandSides.rows() != this->Matrix->rows() || !fits || rightHandSides.outerStride() != rightHandSides.cols())
  {
    throw InvalidInput("CholeskySolver: right-hand sides are " + std::to_string(rightHandSides.rows()) + " by " +
      std::to_string(rightHandSides.cols()) + "; expected " + std::to_string(this->Matrix->rows()) +
      " contiguous rows and one column or a multiple of " + std::to_string(ColumnGranularity) + ".");
  }
}

void CholeskySolver::SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress) const
{
  this->Impl->RequireOrdered(rightHandSides);
  if (rightHandSides.cols() > 0)
  {
    this->Impl->Factor->SolveInPlace(rightHandSides.data(), rightHandSides.cols(), progress);
  }
}

void CholeskySolver::SolveTransposedOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress) const
{
  this->Impl->RequireOrdered(rightHandSides);
  if (rightHandSides.cols() > 0)
  {
    this->Impl->Factor->SolveTransposedInPlace(rightHandSides.data(), rightHandSides.cols(), progress);
  }
}

double CholeskySolver::LogDeterminant() const { return this->Impl->Factor->LogDeterminant(); }

const SparseMatrix& CholeskySolver::Matrix() const { return *this->Impl->Matrix; }

Eigen::MatrixXd CholeskySolver::InverseDiagonals(
  const Eigen::VectorXd& mass, int powers, const Progress& progress) const
{
  if (mass.size() != this->Size() || !mass.allFinite() || mass.minCoeff() < 0.0)
  {
    throw InvalidInput("CholeskySolver: the mass has " + std::to_string(mass.size()) + " entries; expected " +
      std::to_string(this->Size()) + " finite ones of at least 0.");
  }
  if (powers < 1)
  {
    throw InvalidInput(
      "CholeskySolver: " + std::to_string(powers) + " diagonals of inverses asked for; expected at least 1.");
  }
  return this->Impl->InverseDiagonals(mass, powers, progress);
}

void CholeskySolver::SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides) const
{
  if (rightHandSides.rows() != this->Size())
  {
    throw InvalidInput("CholeskySolver: right-hand sides have " + std::to_string(rightHandSides.rows()) +
      " rows; expected " + std::to_string(this->Size()) + ".");
  }
  if (!rightHandSides.allFinite())
  {
    throw InvalidInput("CholeskySolver: a right-hand side is not finite.");
  }
  const std::vector<Index>& order = this->Order();
  const Eigen::Index columns = rightHandSides.cols();
  const Eigen::Index blocks = (columns + BlockColumns - 1) / BlockColumns;
  ParallelTasks(blocks, [&](std::int64_t k) {
    const Eigen::Index first = k * BlockColumns;
    const Eigen::Index count = std::min<Eigen::Index>(BlockColumns, columns - first);
    const Eigen::Index padded = this->PaddedCount(count);
    LargeArray<double> memory(static_cast<std::size_t>(this->Size() * padded));
    Eigen::Map<RowMatrix> block(memory.data(), this->Size(), padded);
    for (Index row = 0; row < this->Size(); ++row)
    {
      block.row(row).head(count) = rightHandSides.row(order[row]).segment(first, count);
      block.row(row).tail(padded - count).setZero();
    }
    this->SolveOrderedInPlace(block);
    for (Index row = 0; row < this->Size(); ++row)
    {
      rightHandSides.row(order[row]).segment(first, count) = block.row(row).head(count);
    }
  });
}

Eigen::VectorXd CholeskySolver::Solve(const Eigen::VectorXd& rightHandSide) const
{
  RowMatrix solution = rightHandSide;
  this->SolveInPlace(solution);
  return solution.col(0);
}

double CholeskySolver::RelativeResidual(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide) const
{
  if (solution.size() != this->Size() || rightHandSide.size() != this->Size())
  {
    throw InvalidInput("CholeskySolver: solution and right-hand side have " + std::to_string(solution.size()) +
      " and " + std::to_string(rightHandSide.size()) + " rows; expected " + std::to_string(this->Size()) + ".");
  }
  // The matrix is symmetric: its columns serve as rows, so that every entry of the product is one sum.
  const SparseMatrix& matrix = *this->Impl->Matrix;
  Eigen::VectorXd residual(this->Size());
  ParallelFor(this->Size(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      double sum = -rightHandSide[row];
      for (SparseMatrix::InnerIterator entry(matrix, row); entry; ++entry)
      {
        sum += entry.value() * solution[entry.row()];
      }
      residual[row] = sum;
    }
  });
  const double norm = rightHandSide.norm();
  return norm > 0.0 ? residual.norm() / norm : 0.0;
}

Eigen::VectorXd SolveCholesky(const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide)
{
  return CholeskySolver(matrix).Solve(rightHandSide);
}

} // namespace surfsynth
