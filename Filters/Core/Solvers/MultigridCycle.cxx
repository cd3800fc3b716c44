// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/MultigridCycle.h"

#include "Core/Common/Parallel.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
/// Least rows of a thread.
constexpr std::int64_t GrainOfColumns(int columns) { return columns == 1 ? 16384 : 4096; }

/// Adds row @p row of the matrix times @p vectors to @p sums, with the sign @p sign.
template <int Columns>
inline void AddProduct(const SparseRows& matrix, std::int64_t row, const float* vectors, float sign, float* sums)
{
  const Index end = matrix.Start.data()[row + 1];
  for (Index k = matrix.Start.data()[row]; k < end; ++k)
  {
    const float value = sign * matrix.Single.data()[k];
    const float* from = vectors + static_cast<std::int64_t>(matrix.Column.data()[k]) * Columns;
    for (int c = 0; c < Columns; ++c)
    {
      sums[c] += value * from[c];
    }
  }
}

/// Calls body(row) for all rows, in parallel.
template <int Columns, typename Body>
void EachRow(std::int64_t rows, const Body& body)
{
  ParallelFor(rows, GrainOfColumns(Columns), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      body(row);
    }
  });
}
} // namespace

template <int Columns>
MultigridCycle<Columns>::MultigridCycle(const MultigridHierarchy& hierarchy)
  : Hierarchy(hierarchy)
{
  for (const MultigridLevel& level : hierarchy.Levels)
  {
    const auto size = static_cast<std::size_t>(level.Matrix.Rows) * Columns;
    this->Vectors.push_back(
      { LargeArray<float>(size), LargeArray<float>(size), LargeArray<float>(size), LargeArray<float>(size) });
  }
  if (hierarchy.Coarsest)
  {
    constexpr Index Granularity = CholeskySolver::ColumnGranularity;
    this->Coarsest = RowMatrix::Zero(
      hierarchy.Coarsest->Size(), (Columns + Granularity - 1) / Granularity * Granularity);
  }
}

template <int Columns>
void MultigridCycle<Columns>::Run(const std::function<void()>& heartbeat)
{
  this->Heartbeat = &heartbeat;
  this->RunLevel(0);
}

template <int Columns>
void MultigridCycle<Columns>::RunLevel(std::size_t level)
{
  const auto beat = [&] {
    if (level == 0)
    {
      (*this->Heartbeat)();
    }
  };
  const bool last = level + 1 == this->Hierarchy.Levels.size();
  if (last && this->Hierarchy.Coarsest)
  {
    this->SolveCoarsest();
    return;
  }
  this->BeginSmoothing(level);
  for (int step = 1; step < MultigridLevel::SmootherSteps; ++step)
  {
    this->SmoothingStep(level, step);
    beat();
  }
  if (last)
  {
    return;
  }
  this->FinishResidual(level);
  beat();
  this->Restrict(level);
  this->RunLevel(level + 1);
  this->Correct(level);
  for (int step = 0; step < MultigridLevel::SmootherSteps; ++step)
  {
    this->SmoothingStep(level, step);
    beat();
  }
}

template <int Columns>
void MultigridCycle<Columns>::BeginSmoothing(std::size_t level)
{
  LevelVectors& vectors = this->Vectors[level];
  const float factor = this->Hierarchy.Levels[level].Residual[0];
  EachRow<Columns>(this->Hierarchy.Levels[level].Matrix.Rows, [&](std::int64_t row) {
    for (std::int64_t at = row * Columns; at < (row + 1) * Columns; ++at)
    {
      const float direction = factor * vectors.Residual.data()[at];
      vectors.Direction.data()[at] = direction;
      vectors.Solution.data()[at] = direction;
    }
  });
}

template <int Columns>
void MultigridCycle<Columns>::SmoothingStep(std::size_t level, int step)
{
  LevelVectors& vectors = this->Vectors[level];
  const MultigridLevel& operators = this->Hierarchy.Levels[level];
  const float ofDirection = operators.Direction[static_cast<std::size_t>(step)];
  const float ofResidual = operators.Residual[static_cast<std::size_t>(step)];
  EachRow<Columns>(operators.Matrix.Rows, [&](std::int64_t row) {
    const std::int64_t first = row * Columns;
    float residual[Columns];
    std::copy_n(vectors.Residual.data() + first, Columns, residual);
    AddProduct<Columns>(operators.Matrix, row, vectors.Direction.data(), -1.0F, residual);
    for (int c = 0; c < Columns; ++c)
    {
      const float direction = ofDirection * vectors.Direction.data()[first + c] + ofResidual * residual[c];
      vectors.Residual.data()[first + c] = residual[c];
      vectors.Next.data()[first + c] = direction;
      vectors.Solution.data()[first + c] += direction;
    }
  });
  std::swap(vectors.Direction, vectors.Next);
}

template <int Columns>
void MultigridCycle<Columns>::FinishResidual(std::size_t level)
{
  LevelVectors& vectors = this->Vectors[level];
  const SparseRows& matrix = this->Hierarchy.Levels[level].Matrix;
  EachRow<Columns>(matrix.Rows, [&](std::int64_t row) {
    float residual[Columns];
    std::copy_n(vectors.Residual.data() + row * Columns, Columns, residual);
    AddProduct<Columns>(matrix, row, vectors.Direction.data(), -1.0F, residual);
    std::copy_n(residual, Columns, vectors.Residual.data() + row * Columns);
  });
}

template <int Columns>
void MultigridCycle<Columns>::Restrict(std::size_t level)
{
  const float* fine = this->Vectors[level].Residual.data();
  float* coarse = this->Vectors[level + 1].Residual.data();
  const SparseRows& restriction = this->Hierarchy.Levels[level].Restriction;
  EachRow<Columns>(restriction.Rows, [&](std::int64_t row) {
    float sums[Columns] = {};
    AddProduct<Columns>(restriction, row, fine, 1.0F, sums);
    std::copy_n(sums, Columns, coarse + row * Columns);
  });
}

template <int Columns>
void MultigridCycle<Columns>::Correct(std::size_t level)
{
  LevelVectors& vectors = this->Vectors[level];
  const float* coarse = this->Vectors[level + 1].Solution.data();
  const SparseRows& prolongation = this->Hierarchy.Levels[level].Prolongation;
  EachRow<Columns>(prolongation.Rows, [&](std::int64_t row) {
    float sums[Columns] = {};
    AddProduct<Columns>(prolongation, row, coarse, 1.0F, sums);
    for (int c = 0; c < Columns; ++c)
    {
      vectors.Direction.data()[row * Columns + c] = sums[c];
      vectors.Solution.data()[row * Columns + c] += sums[c];
    }
  });
}

template <int Columns>
void MultigridCycle<Columns>::SolveCoarsest()
{
  const std::vector<Index>& order = this->Hierarchy.Coarsest->Order();
  LevelVectors& vectors = this->Vectors.back();
  for (std::size_t row = 0; row < order.size(); ++row)
  {
    for (int c = 0; c < Columns; ++c)
    {
      this->Coarsest(static_cast<Index>(row), c) = static_cast<double>(
        vectors.Residual.data()[static_cast<std::int64_t>(order[row]) * Columns + c]);
    }
  }
  this->Hierarchy.Coarsest->SolveOrderedInPlace(this->Coarsest);
  for (std::size_t row = 0; row < order.size(); ++row)
  {
    for (int c = 0; c < Columns; ++c)
    {
      vectors.Solution.data()[static_cast<std::int64_t>(order[row]) * Columns + c] = static_cast<float>(
        this->Coarsest(static_cast<Index>(row), c));
    }
  }
}

template class MultigridCycle<1>;
template class MultigridCycle<4>;
template class MultigridCycle<8>;

} // namespace surfsynth
