// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/MultigridSolver.h"

#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/ConjugateGradients.h"
#include "Core/Solvers/MultigridHierarchy.h"
#include "Core/Solvers/SymmetricMatrix.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace surfsynth
{

namespace
{
constexpr int WidestBlock = 8;

void ValidateOptions(const MultigridOptions& options)
{
  if (!(options.Tolerance >= 1e-14 && options.Tolerance <= 0.1))
  {
    throw InvalidInput(
      "MultigridSolver: the tolerance is " + FormatNumber(options.Tolerance) + "; expected 1e-14 to 0.1.");
  }
  if (options.MaximumIterations < 1)
  {
    throw InvalidInput("MultigridSolver: the largest number of iterations is " +
      std::to_string(options.MaximumIterations) + "; expected at least 1.");
  }
}

void RequireMemory(const SparseMatrix& matrix, const MultigridOptions& options)
{
  const std::uint64_t needed = MultigridSolver::EstimateMemory(matrix.rows(), matrix.nonZeros());
  const std::uint64_t limit = options.MemoryLimit > 0 ? options.MemoryLimit : AvailableMemory();
  if (needed > limit)
  {
    constexpr std::uint64_t MiB = 1U << 20U;
    throw InvalidInput("MultigridSolver: " + std::to_string(matrix.rows()) + " rows with " +
      std::to_string(matrix.nonZeros()) + " entries take about " + std::to_string(needed / MiB + 1) +
      " MiB; expected at most " + std::to_string(limit / MiB) + " MiB.");
  }
}
} // namespace

class MultigridSolver::Internals
{
public:
  explicit Internals(const MultigridOptions& options)
    : Options(options)
  {}
  /// Solves @p count columns of @p sides from number @p first on.
  template <int Columns>
  void SolveColumns(
    Eigen::Ref<RowMatrix> sides, Eigen::Index first, Eigen::Index count, const Index* rowOf, const Progress& progress);

  /// Solves in place; row @p rowOf[r] of @p sides is that of row r, or row r itself for null.
  void Solve(Eigen::Ref<RowMatrix> sides, const Index* rowOf, const Progress& progress);

  const MultigridOptions Options;
  std::vector<Index> Order;
  std::unique_ptr<MultigridHierarchy> Hierarchy;
  std::mutex ReportMutex;
  IterationReport Largest;
};

template <int Columns>
void MultigridSolver::Internals::SolveColumns(
  Eigen::Ref<RowMatrix> sides, Eigen::Index first, Eigen::Index count, const Index* rowOf, const Progress& progress)
{
  ConjugateGradients<Columns> solver(*this->Hierarchy, { this->Options.Tolerance, this->Options.MaximumIterations });
  const auto eachRow = [&](const auto& body) {
    ParallelFor(sides.rows(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t row = begin; row < end; ++row)
      {
        body(solver.Block() + row * Columns, &sides(rowOf ? rowOf[row] : row, first));
      }
    });
  };
  eachRow([&](double* to, const double* from) { std::fill(std::copy_n(from, count, to), to + Columns, 0.0); });
  const IterationReport report = solver.Run(progress);
  eachRow([&](const double* from, double* to) { std::copy_n(from, count, to); });
  std::lock_guard<std::mutex> lock(this->ReportMutex);
  this->Largest.Iterations = std::max(this->Largest.Iterations, report.Iterations);
  this->Largest.RelativeResidual = std::max(this->Largest.RelativeResidual, report.RelativeResidual);
}

MultigridSolver::MultigridSolver(SparseMatrix matrix, const MultigridOptions& options, const Progress& progress)
  : Impl(std::make_unique<Internals>(options))
{
  ValidateOptions(options);
  RequireSquare(matrix, "MultigridSolver");
  RequireMemory(matrix, options);
  matrix = Sorted(std::move(matrix));
  RequireSymmetric(matrix, "MultigridSolver");
  Report(progress, 0.05);
  this->Impl->Order = BreadthFirstOrder(matrix, SubProgress(progress, 0.05, 0.15));
  SparseRows rows = Reordered(matrix, this->Impl->Order);
  matrix = SparseMatrix();
  Report(progress, 0.2);
  this->Impl->Hierarchy = std::make_unique<MultigridHierarchy>(std::move(rows), SubProgress(progress, 0.2, 1.0));
}

MultigridSolver::~MultigridSolver() = default;
MultigridSolver::MultigridSolver(MultigridSolver&&) noexcept = default;
MultigridSolver& MultigridSolver::operator=(MultigridSolver&&) noexcept = default;

void MultigridSolver::Internals::Solve(Eigen::Ref<RowMatrix> sides, const Index* rowOf, const Progress& progress)
{
  if (sides.rows() != this->Hierarchy->Levels.front().Matrix.Rows)
  {
    throw InvalidInput("MultigridSolver: right-hand sides have " + std::to_string(sides.rows()) + " rows; expected " +
      std::to_string(this->Hierarchy->Levels.front().Matrix.Rows) + ".");
  }
  const Eigen::Index columns = sides.cols();
  for (Eigen::Index first = 0; first < columns; first += WidestBlock)
  {
    const Eigen::Index count = std::min<Eigen::Index>(WidestBlock, columns - first);
    const Progress part = SubProgress(progress, static_cast<double>(first) / static_cast<double>(columns),
      static_cast<double>(first + count) / static_cast<double>(columns));
    if (count == 1)
    {
      this->SolveColumns<1>(sides, first, count, rowOf, part);
    }
    else if (count <= 4)
    {
      this->SolveColumns<4>(sides, first, count, rowOf, part);
    }
    else
    {
      this->SolveColumns<8>(sides, first, count, rowOf, part);
    }
  }
  Report(progress, 1.0);
}

void MultigridSolver::SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress) const
{
  if (!rightHandSides.allFinite())
  {
    throw InvalidInput("MultigridSolver: a right-hand side is not finite.");
  }
  this->Impl->Solve(rightHandSides, this->Impl->Order.data(), progress);
}

void MultigridSolver::SolveInPlace(Eigen::Ref<RowMatrix> rightHandSides) const
{
  this->SolveInPlace(rightHandSides, {});
}

void MultigridSolver::SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const Progress& progress) const
{
  this->Impl->Solve(rightHandSides, nullptr, progress);
}

Eigen::VectorXd MultigridSolver::Solve(const Eigen::VectorXd& rightHandSide) const
{
  RowMatrix solution = rightHandSide;
  this->SolveInPlace(solution);
  return solution.col(0);
}

const std::vector<Index>& MultigridSolver::Order() const { return this->Impl->Order; }

double MultigridSolver::RelativeResidual(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide) const
{
  if (solution.size() != this->Size() || rightHandSide.size() != this->Size())
  {
    throw InvalidInput("MultigridSolver: solution and right-hand side have " + std::to_string(solution.size()) +
      " and " + std::to_string(rightHandSide.size()) + " rows; expected " + std::to_string(this->Size()) + ".");
  }
  const std::vector<Index>& order = this->Impl->Order;
  const SparseRows& matrix = this->Impl->Hierarchy->Levels.front().Matrix;
  Eigen::VectorXd residual(this->Size());
  ParallelFor(this->Size(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = static_cast<std::size_t>(begin); row < static_cast<std::size_t>(end); ++row)
    {
      double sum = -rightHandSide[order[row]];
      for (Index k = matrix.Start[row]; k < matrix.Start[row + 1]; ++k)
      {
        const auto entry = static_cast<std::size_t>(k);
        sum += matrix.Value[entry] * solution[order[static_cast<std::size_t>(matrix.Column[entry])]];
      }
      residual[static_cast<Eigen::Index>(row)] = sum;
    }
  });
  const double norm = rightHandSide.norm();
  return norm > 0.0 ? residual.norm() / norm : 0.0;
}

RowMatrix MultigridSolver::Multiply(const RowMatrix& values) const
{
  if (values.rows() != this->Size())
  {
    throw InvalidInput("MultigridSolver: vectors have " + std::to_string(values.rows()) + " rows; expected " +
      std::to_string(this->Size()) + ".");
  }
  const std::vector<Index>& order = this->Impl->Order;
  const SparseRows& matrix = this->Impl->Hierarchy->Levels.front().Matrix;
  RowMatrix products(values.rows(), values.cols());
  ParallelFor(this->Size(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    Eigen::RowVectorXd sums(values.cols());
    for (auto row = static_cast<std::size_t>(begin); row < static_cast<std::size_t>(end); ++row)
    {
      sums.setZero();
      for (Index k = matrix.Start[row]; k < matrix.Start[row + 1]; ++k)
      {
        const auto entry = static_cast<std::size_t>(k);
        sums += matrix.Value[entry] * values.row(order[static_cast<std::size_t>(matrix.Column[entry])]);
      }
      products.row(order[row]) = sums;
    }
  });
  return products;
}

int MultigridSolver::Iterations() const
{
  std::lock_guard<std::mutex> lock(this->Impl->ReportMutex);
  return this->Impl->Largest.Iterations;
}

double MultigridSolver::LargestResidual() const
{
  std::lock_guard<std::mutex> lock(this->Impl->ReportMutex);
  return this->Impl->Largest.RelativeResidual;
}

Index MultigridSolver::Size() const { return this->Impl->Hierarchy->Levels.front().Matrix.Rows; }

int MultigridSolver::NumberOfLevels() const { return static_cast<int>(this->Impl->Hierarchy->Levels.size()); }

double MultigridSolver::OperatorComplexity() const { return this->Impl->Hierarchy->OperatorComplexity(); }

std::int64_t MultigridSolver::MemoryInUse() const
{
  return this->Impl->Hierarchy->Bytes() + static_cast<std::int64_t>(this->Impl->Order.size() * sizeof(Index));
}

std::uint64_t MultigridSolver::EstimateMemory(std::int64_t rows, std::int64_t entries, std::int64_t columns)
{
  const std::int64_t together = columns <= 1 ? 1 : columns <= 4 ? 4 : WidestBlock;
  return static_cast<std::uint64_t>(28 * entries + (90 + 60 * together) * rows);
}

} // namespace surfsynth
