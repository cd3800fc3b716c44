// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/ConjugateGradients.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
/// Rows of a chunk, whose sums are added in order.
constexpr std::int64_t ChunkRows = 2048;
/// Least factor by which the residual must fall between two checks of b - A x.
constexpr double LeastGain = 0.5;
/// Units of rounding of A x that a residual may have where the tolerance asks for less.
constexpr double RoundingFactor = 1.0;
} // namespace

template <int Columns>
ConjugateGradients<Columns>::ConjugateGradients(const MultigridHierarchy& hierarchy, const IterationLimits& limits)
  : Hierarchy(hierarchy)
  , Limits(limits)
  , Cycle(hierarchy)
{
  const auto rows = static_cast<std::size_t>(hierarchy.Levels.front().Matrix.Rows);
  for (LargeArray<double>* vector :
    { &this->RightHandSide, &this->Solution, &this->Residual, &this->Direction, &this->Product })
  {
    *vector = LargeArray<double>(rows * Columns);
  }
}

/// Adds what body(row, sums) adds to @p Count sums for all rows, in parallel over chunks of fixed size.
template <int Columns>
template <std::size_t Count, typename Body>
std::array<double, Count> ConjugateGradients<Columns>::SumOf(const Body& body)
{
  const std::int64_t rows = this->Hierarchy.Levels.front().Matrix.Rows;
  const std::int64_t chunks = (rows + ChunkRows - 1) / ChunkRows;
  constexpr std::int64_t Grain = Columns == 1 ? 8 : 2;
  std::vector<std::array<double, Count>> parts(static_cast<std::size_t>(chunks));
  ParallelFor(chunks, Grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t chunk = begin; chunk < end; ++chunk)
    {
      std::array<double, Count> sums{};
      const std::int64_t last = std::min(rows, (chunk + 1) * ChunkRows);
      for (std::int64_t row = chunk * ChunkRows; row < last; ++row)
      {
        body(row, sums);
      }
      parts[static_cast<std::size_t>(chunk)] = sums;
    }
  });
  std::array<double, Count> total{};
  for (const std::array<double, Count>& sums : parts)
  {
    for (std::size_t c = 0; c < Count; ++c)
    {
      total[c] += sums[c];
    }
  }
  this->Beat();
  return total;
}

template <int Columns>
void ConjugateGradients<Columns>::Beat()
{
  Report(this->Callback, this->Fraction);
}

/// Power of two of the mean absolute value.
static double PowerOfMean(double sum, std::int64_t rows)
{
  return std::exp2(std::floor(std::log2(sum / static_cast<double>(rows))));
}

template <int Columns>
void ConjugateGradients<Columns>::Begin()
{
  const std::int64_t rows = this->Hierarchy.Levels.front().Matrix.Rows;
  const Numbers sizes = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      sums[c] += std::abs(this->RightHandSide[static_cast<std::size_t>(row) * Columns + c]);
    }
  });
  for (std::size_t c = 0; c < Columns; ++c)
  {
    this->Active[c] = sizes[c] > 0.0;
    this->Unit[c] = this->Active[c] ? PowerOfMean(sizes[c], rows) : 1.0;
    this->Restarted[c] = true;
  }
  const Numbers squares = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      const double side = this->RightHandSide[at] / this->Unit[c];
      this->RightHandSide[at] = this->Residual[at] = side;
      this->Solution[at] = this->Direction[at] = this->Product[at] = 0.0;
      sums[c] += side * side;
    }
  });
  const Numbers scaled = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      sums[c] += std::abs(
        this->Residual[static_cast<std::size_t>(row) * Columns + c] / this->Hierarchy.Root.data()[row]);
    }
  });
  for (std::size_t c = 0; c < Columns; ++c)
  {
    this->Norm[c] = this->Norms[c] = this->Checked[c] = std::sqrt(squares[c]);
    this->Scale[c] = this->Active[c] ? 1.0 / PowerOfMean(scaled[c], rows) : 1.0;
  }
}

template <int Columns>
void ConjugateGradients<Columns>::Precondition()
{
  float* to = this->Cycle.RightHandSides();
  this->Sum([&](std::int64_t row, Numbers&) {
    const double root = this->Hierarchy.Root.data()[row];
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      to[at] = static_cast<float>(this->Scale[c] * this->Residual[at] / root);
    }
  });
  this->Cycle.Run([this] { this->Beat(); });
}

/// Makes the next direction of the preconditioned residual, and returns its products with A times itself.
template <int Columns>
typename ConjugateGradients<Columns>::Numbers ConjugateGradients<Columns>::TurnDirection()
{
  const float* preconditioned = this->Cycle.Solutions();
  const double* roots = this->Hierarchy.Root.data();
  const Numbers projected = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      sums[c] += static_cast<double>(preconditioned[at]) / roots[row] * this->Residual[at];
    }
  });
  const Numbers change = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      sums[c] += static_cast<double>(preconditioned[at]) / roots[row] * this->Product[at];
    }
  });
  Numbers turn{};
  for (std::size_t c = 0; c < Columns; ++c)
  {
    if (this->Active[c])
    {
      this->RequirePositive(projected[c]);
      // (z, r - r') / (z', r') with r - r' = - step A p
      turn[c] = this->Restarted[c] ? 0.0 : -this->Step[c] * change[c] / this->Projected[c];
      this->Restarted[c] = false;
      this->Projected[c] = projected[c];
    }
  }
  this->Sum([&](std::int64_t row, Numbers&) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      this->Direction[at] = static_cast<double>(preconditioned[at]) / roots[row] + turn[c] * this->Direction[at];
    }
  });
  const SparseRows& matrix = this->Hierarchy.Levels.front().Matrix;
  return this->Sum([&](std::int64_t row, Numbers& sums) {
    Numbers product{};
    for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
    {
      const double value = matrix.Value.data()[k];
      const double* from = this->Direction.data() + static_cast<std::int64_t>(matrix.Column.data()[k]) * Columns;
      for (std::size_t c = 0; c < Columns; ++c)
      {
        product[c] += value * from[c];
      }
    }
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      this->Product[at] = product[c];
      sums[c] += product[c] * this->Direction[at];
    }
  });
}

/// Goes along the directions.
template <int Columns>
void ConjugateGradients<Columns>::Advance(const Numbers& step)
{
  const Numbers squares = this->Sum([&](std::int64_t row, Numbers& sums) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      const double residual = this->Residual[at] - step[c] * this->Product[at];
      this->Solution[at] += step[c] * this->Direction[at];
      this->Residual[at] = residual;
      sums[c] += residual * residual;
    }
  });
  for (std::size_t c = 0; c < Columns; ++c)
  {
    this->Norms[c] = this->Active[c] ? std::sqrt(squares[c]) : this->Norms[c];
  }
}

/// Computes b - A x for the columns whose residual has reached the tolerance.
template <int Columns>
void ConjugateGradients<Columns>::CheckCandidates()
{
  std::array<bool, Columns> candidate{};
  for (std::size_t c = 0; c < Columns; ++c)
  {
    candidate[c] = this->Active[c] && this->Norms[c] <= this->Limits.Tolerance * this->Norm[c];
  }
  if (std::none_of(candidate.begin(), candidate.end(), [](bool is) { return is; }))
  {
    return;
  }
  const SparseRows& matrix = this->Hierarchy.Levels.front().Matrix;
  // Beside b - A x, || |A| |x| ||: what it is rounded to.
  std::array<double, 2 * Columns> totals = this->template SumOf<2 * Columns>([&](std::int64_t row, auto& sums) {
    const std::size_t first = static_cast<std::size_t>(row) * Columns;
    Numbers residual;
    Numbers magnitude{};
    std::copy_n(this->RightHandSide.data() + first, Columns, residual.data());
    for (Index k = matrix.Start.data()[row]; k < matrix.Start.data()[row + 1]; ++k)
    {
      const double value = matrix.Value.data()[k];
      const double* from = this->Solution.data() + static_cast<std::int64_t>(matrix.Column.data()[k]) * Columns;
      for (std::size_t c = 0; c < Columns; ++c)
      {
        residual[c] -= value * from[c];
        magnitude[c] += std::abs(value * from[c]);
      }
    }
    for (std::size_t c = 0; c < Columns; ++c)
    {
      this->Residual[first + c] = candidate[c] ? residual[c] : this->Residual[first + c];
      sums[c] += residual[c] * residual[c];
      sums[Columns + c] += magnitude[c] * magnitude[c];
    }
  });
  for (std::size_t c = 0; c < Columns; ++c)
  {
    if (!candidate[c])
    {
      continue;
    }
    this->Norms[c] = std::sqrt(totals[c]);
    const double rounding = RoundingFactor * std::numeric_limits<double>::epsilon() * std::sqrt(totals[Columns + c]);
    this->Active[c] = !(this->Norms[c] <= std::max(this->Limits.Tolerance * this->Norm[c], rounding));
    this->Restarted[c] = true;
    if (this->Active[c] && !(this->Norms[c] <= LeastGain * this->Checked[c]))
    {
      this->ThrowNotConverged(c);
    }
    this->Checked[c] = this->Norms[c];
  }
}

template <int Columns>
void ConjugateGradients<Columns>::RequirePositive(double product) const
{
  if (!(product > 0.0) || !std::isfinite(product))
  {
    throw SolverFailure("MultigridSolver: a quadratic form of the matrix of size " +
      std::to_string(this->Hierarchy.Levels.front().Matrix.Rows) + " is " + FormatNumber(product) +
      "; expected a symmetric positive definite matrix. Needle triangles or a screening term that is tiny for the size "
      "of the mesh cause this.");
  }
}

template <int Columns>
void ConjugateGradients<Columns>::ThrowNotConverged(std::size_t column) const
{
  throw SolverFailure("MultigridSolver: the relative residual is " +
    FormatNumber(this->Norms[column] / this->Norm[column]) + " after " + std::to_string(this->Iteration) +
    " iterations; expected at most " + FormatNumber(this->Limits.Tolerance) +
    ". Needle triangles, or a screening term that is tiny for the size of the mesh, make the system ill-conditioned: "
    "remesh, or use a smaller correlation range.");
}

template <int Columns>
IterationReport ConjugateGradients<Columns>::Run(const Progress& progress)
{
  this->Callback = progress;
  this->Fraction = 0.0;
  this->Iteration = 0;
  this->Begin();
  IterationReport report;
  while (std::any_of(this->Active.begin(), this->Active.end(), [](bool active) { return active; }))
  {
    if (this->Iteration == this->Limits.MostIterations)
    {
      const auto open = std::find(this->Active.begin(), this->Active.end(), true);
      this->ThrowNotConverged(static_cast<std::size_t>(open - this->Active.begin()));
    }
    ++this->Iteration;
    this->Precondition();
    const Numbers energies = this->TurnDirection();
    for (std::size_t c = 0; c < Columns; ++c)
    {
      this->Step[c] = 0.0;
      if (this->Active[c])
      {
        this->RequirePositive(energies[c]);
        this->Step[c] = this->Projected[c] / energies[c];
      }
    }
    this->Advance(this->Step);
    this->CheckCandidates();
    double slowest = 1.0;
    for (std::size_t c = 0; c < Columns; ++c)
    {
      if (this->Active[c])
      {
        slowest = std::min(slowest, std::log(this->Norms[c] / this->Norm[c]) / std::log(this->Limits.Tolerance));
      }
    }
    this->Fraction = std::clamp(slowest, this->Fraction, 1.0);
    this->Beat();
  }
  report.Iterations = this->Iteration;
  for (std::size_t c = 0; c < Columns; ++c)
  {
    if (this->Norm[c] > 0.0)
    {
      report.RelativeResidual = std::max(report.RelativeResidual, this->Norms[c] / this->Norm[c]);
    }
  }
  this->Sum([&](std::int64_t row, Numbers&) {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      const std::size_t at = static_cast<std::size_t>(row) * Columns + c;
      this->RightHandSide[at] = this->Solution[at] * this->Unit[c];
    }
  });
  this->Callback = {};
  return report;
}

template class ConjugateGradients<1>;
template class ConjugateGradients<4>;
template class ConjugateGradients<8>;

} // namespace surfsynth
