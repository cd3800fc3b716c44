// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/MultigridHierarchy.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/Aggregation.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
constexpr Index MostRowsOfStagnation = 20000;
constexpr double Stagnation = 0.8;

/// Writes the scaled matrix to Single: A_ij / (root_i root_j), or A itself without roots.
void ScaleToSingle(SparseRows& matrix, const LargeArray<double>& root)
{
  matrix.Single = LargeArray<float>(static_cast<std::size_t>(matrix.Entries()));
  ParallelFor(matrix.Rows, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
      {
        const double scale = root.size() > 0 ? root.data()[row] * root.data()[matrix.Column.data()[k]] : 1.0;
        matrix.Single.data()[k] = static_cast<float>(matrix.Value.data()[k] / scale);
      }
    }
  });
}

/// Diagonal entries.
LargeArray<double> Diagonal(const SparseRows& matrix)
{
  LargeArray<double> diagonal(static_cast<std::size_t>(matrix.Rows));
  ParallelFor(matrix.Rows, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      diagonal.data()[row] = 0.0;
      for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
      {
        diagonal.data()[row] += matrix.Column.data()[k] == row ? matrix.Value.data()[k] : 0.0;
      }
    }
  });
  return diagonal;
}

/// Scales a coarse matrix to a unit diagonal, and the interpolation and the near-null vector with it.
void ScaleLevel(SparseRows& matrix, SparseRows& prolongation, LargeArray<double>& smooth)
{
  LargeArray<double> root = Diagonal(matrix);
  for (Index row = 0; row < matrix.Rows; ++row)
  {
    double& entry = root.data()[row];
    if (!(entry > 0.0) || !std::isfinite(entry))
    {
      throw SolverFailure("MultigridSolver: a diagonal entry of a coarse matrix is " + FormatNumber(entry) +
        "; expected a symmetric positive definite matrix.");
    }
    entry = std::sqrt(entry);
    smooth.data()[row] *= entry;
  }
  ParallelFor(matrix.Rows, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
      {
        matrix.Value.data()[k] /= root.data()[row] * root.data()[matrix.Column.data()[k]];
      }
    }
  });
  ParallelFor(prolongation.Entries(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      float& value = prolongation.Single.data()[k];
      value = static_cast<float>(static_cast<double>(value) / root.data()[prolongation.Column.data()[k]]);
    }
  });
}

/// Largest sum of absolute values of a row: a bound of the largest eigenvalue.
double LargestRowSum(const SparseRows& matrix)
{
  double largest = 0.0;
  for (Index row = 0; row < matrix.Rows; ++row)
  {
    double sum = 0.0;
    for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
    {
      sum += std::abs(static_cast<double>(matrix.Single.data()[k]));
    }
    largest = std::max(largest, sum);
  }
  return largest;
}

/// Sum of products of two vectors in chunks of fixed size, so that it does not depend on the number of threads.
double ChunkedDot(const LargeArray<float>& a, const LargeArray<float>& b)
{
  constexpr std::int64_t Chunk = 4096;
  const auto size = static_cast<std::int64_t>(a.size());
  std::vector<double> sums(static_cast<std::size_t>((size + Chunk - 1) / Chunk), 0.0);
  ParallelFor(static_cast<std::int64_t>(sums.size()), FineGrain / Chunk, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t chunk = begin; chunk < end; ++chunk)
    {
      double sum = 0.0;
      for (std::int64_t i = chunk * Chunk; i < std::min(size, (chunk + 1) * Chunk); ++i)
      {
        sum += static_cast<double>(a.data()[i]) * static_cast<double>(b.data()[i]);
      }
      sums[static_cast<std::size_t>(chunk)] = sum;
    }
  });
  double total = 0.0;
  for (const double sum : sums)
  {
    total += sum;
  }
  return total;
}

/// Entry of a vector of well-mixed signs.
float MixedSign(std::uint64_t row)
{
  std::uint64_t bits = (row + 1) * 0x9E3779B97F4A7C15ULL;
  bits = (bits ^ (bits >> 31)) * 0xBF58476D1CE4E5B9ULL;
  return ((bits >> 40) & 1U) != 0 ? 1.0F : -1.0F;
}

/// The largest eigenvalue of the scaled matrix by steps of Lanczos, from below.
double LargestRitzValue(const SparseRows& matrix)
{
  constexpr Eigen::Index Steps = 12;
  const auto size = static_cast<std::size_t>(matrix.Rows);
  LargeArray<float> previous(size);
  LargeArray<float> current(size);
  LargeArray<float> next(size);
  std::fill(previous.data(), previous.data() + size, 0.0F);
  const float scale = static_cast<float>(1.0 / std::sqrt(static_cast<double>(size)));
  for (std::size_t row = 0; row < size; ++row)
  {
    current[row] = scale * MixedSign(row);
  }
  Eigen::MatrixXd projected = Eigen::MatrixXd::Zero(Steps, Steps);
  Eigen::Index steps = 0;
  double beta = 0.0;
  const auto eachRow = [&](const auto& body) {
    ParallelFor(matrix.Rows, FineGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t row = begin; row < end; ++row)
      {
        next.data()[row] = body(row);
      }
    });
  };
  while (steps < Steps)
  {
    eachRow([&](std::int64_t row) {
      float sum = static_cast<float>(-beta) * previous.data()[row];
      for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
      {
        sum += matrix.Single.data()[k] * current.data()[matrix.Column.data()[k]];
      }
      return sum;
    });
    const double alpha = ChunkedDot(next, current);
    projected(steps, steps) = alpha;
    eachRow([&](std::int64_t row) { return next.data()[row] - static_cast<float>(alpha) * current.data()[row]; });
    beta = std::sqrt(ChunkedDot(next, next));
    if (++steps == Steps || !(beta > 1e-5))
    {
      break;
    }
    projected(steps, steps - 1) = projected(steps - 1, steps) = beta;
    eachRow([&](std::int64_t row) { return next.data()[row] / static_cast<float>(beta); });
    std::swap(previous, current);
    std::swap(current, next);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
    projected.topLeftCorner(steps, steps), Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[steps - 1];
}

/// Sets the factors of the smoother for the spectrum of the scaled matrix.
void ChooseSmoother(MultigridLevel& level)
{
  const double bound = std::min(LargestRowSum(level.Matrix), 1.1 * LargestRitzValue(level.Matrix));
  for (int step = 0; step < MultigridLevel::SmootherSteps; ++step)
  {
    level.Direction[static_cast<std::size_t>(step)] = static_cast<float>((2.0 * step - 1.0) / (2.0 * step + 3.0));
    level.Residual[static_cast<std::size_t>(step)] = static_cast<float>(
      (8.0 * step + 4.0) / ((2.0 * step + 3.0) * bound));
  }
  level.Direction[0] = 0.0F;
}

/// Factor of the scaled matrix of the last level, A_ij / (root_i root_j), or A itself without roots.
CholeskySolver FactorOf(const SparseRows& matrix, const LargeArray<double>& root)
{
  const auto scale = [&root](Index row) { return root.size() > 0 ? 1.0 / root.data()[row] : 1.0; };
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(static_cast<std::size_t>(matrix.Entries()));
  for (Index row = 0; row < matrix.Rows; ++row)
  {
    for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
    {
      // Both triangles hold the sums of the same products in other orders: one stands for both.
      const Index column = matrix.Column.data()[k];
      const double value = scale(row) * matrix.Value.data()[k] * scale(column);
      if (column < row)
      {
        entries.emplace_back(row, column, value);
        entries.emplace_back(column, row, value);
      }
      else if (column == row)
      {
        entries.emplace_back(row, row, value + 1e-14);
      }
    }
  }
  SparseMatrix factored(matrix.Rows, matrix.Rows);
  factored.setFromTriplets(entries.begin(), entries.end());
  return CholeskySolver(factored);
}
} // namespace

void MultigridHierarchy::TakeRoots()
{
  this->Root = Diagonal(this->Levels.front().Matrix);
  for (std::size_t row = 0; row < this->Root.size(); ++row)
  {
    double& entry = this->Root[row];
    if (!(entry > 0.0))
    {
      throw SolverFailure("MultigridSolver: a diagonal entry is " + FormatNumber(entry) +
        "; expected a symmetric positive definite matrix.");
    }
    entry = std::sqrt(entry);
  }
}

MultigridHierarchy::MultigridHierarchy(SparseRows matrix, const Progress& progress)
{
  const double work = 1.25 * static_cast<double>(matrix.Entries());
  double done = 0.0;
  this->Levels.emplace_back();
  this->Levels.front().Matrix = std::move(matrix);
  this->TakeRoots();
  const LargeArray<double> none;
  LargeArray<double> smooth;
  for (;;)
  {
    const bool finest = this->Levels.size() == 1;
    MultigridLevel& level = this->Levels.back();
    const double part = static_cast<double>(level.Matrix.Entries()) / work;
    const auto step = [&](double begin, double end) {
      return SubProgress(progress, std::min(1.0, done + begin * part), std::min(1.0, done + end * part));
    };
    const LargeArray<double>& root = finest ? this->Root : none;
    ScaleToSingle(level.Matrix, root);
    Report(step(0.0, 0.1), 1.0);
    ChooseSmoother(level);
    Report(step(0.1, 0.2), 1.0);
    if (level.Matrix.Rows <= FactoredRows)
    {
      this->Coarsest.emplace(FactorOf(level.Matrix, root));
      break;
    }
    AggregationResult coarse = Aggregate({ level.Matrix, root, finest ? root : smooth }, step(0.2, 0.5));
    const Index rows = coarse.Prolongation.Columns;
    if (rows == 0 || rows > Stagnation * level.Matrix.Rows)
    {
      if (rows > 0 && level.Matrix.Rows <= MostRowsOfStagnation)
      {
        this->Coarsest.emplace(FactorOf(level.Matrix, root));
      }
      break;
    }
    level.Prolongation = std::move(coarse.Prolongation);
    level.Restriction = Transposed(level.Prolongation);
    Report(step(0.5, 0.6), 1.0);
    SparseRows product = GalerkinProduct(level.Matrix, root, level.Prolongation, level.Restriction, step(0.6, 1.0));
    smooth = std::move(coarse.Smooth);
    ScaleLevel(product, level.Prolongation, smooth);
    level.Restriction = Transposed(level.Prolongation);
    if (!finest)
    {
      level.Matrix.Value = LargeArray<double>();
    }
    done += part;
    this->Levels.emplace_back();
    this->Levels.back().Matrix = std::move(product);
  }
  Report(progress, 1.0);
}

double MultigridHierarchy::OperatorComplexity() const
{
  double entries = 0.0;
  for (const MultigridLevel& level : this->Levels)
  {
    entries += static_cast<double>(level.Matrix.Entries());
  }
  return entries / static_cast<double>(this->Levels.front().Matrix.Entries());
}

std::int64_t MultigridHierarchy::Bytes() const
{
  auto bytes = static_cast<std::int64_t>(this->Root.size() * sizeof(double));
  for (const MultigridLevel& level : this->Levels)
  {
    bytes += level.Matrix.Bytes() + level.Prolongation.Bytes() + level.Restriction.Bytes();
  }
  return this->Coarsest ? bytes + 8 * this->Coarsest->FactorEntries() : bytes;
}

} // namespace surfsynth
