// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The cycle of a multigrid method for several right-hand sides. Private to the solvers.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Solvers/MultigridHierarchy.h"

#include <functional>
#include <vector>

namespace surfsynth
{

/// Applies one V-cycle, symmetric and in single precision, to @p Columns right-hand sides, row-major. Every column has
/// the bits that it has alone.
template <int Columns>
class MultigridCycle
{
public:
  /// Allocates the vectors of all levels: 16 bytes for each number of each level.
  explicit MultigridCycle(const MultigridHierarchy& hierarchy);

  /// Right-hand sides of the finest level, [V, Columns], of the matrix scaled to a unit diagonal: to be filled before
  /// Run(), which overwrites them.
  float* RightHandSides() { return this->Vectors.front().Residual.data(); }
  /// Approximate solutions after Run(), [V, Columns].
  const float* Solutions() const { return this->Vectors.front().Solution.data(); }
  /// Runs the cycle. @p heartbeat is called after each pass over the finest level.
  void Run(const std::function<void()>& heartbeat);

  /// Bytes that the vectors take on @p rows rows of all levels.
  static std::int64_t Bytes(std::int64_t rows) { return 4 * static_cast<std::int64_t>(sizeof(float)) * Columns * rows; }

private:
  struct LevelVectors
  {
    LargeArray<float> Residual;
    LargeArray<float> Solution;
    LargeArray<float> Direction;
    LargeArray<float> Next;
  };
  void RunLevel(std::size_t level);
  void BeginSmoothing(std::size_t level);
  void SmoothingStep(std::size_t level, int step);
  void FinishResidual(std::size_t level);
  void Restrict(std::size_t level);
  void Correct(std::size_t level);
  void SolveCoarsest();

  const MultigridHierarchy& Hierarchy;
  std::vector<LevelVectors> Vectors;
  RowMatrix Coarsest; ///< of the factored level, in the order of its factor
  const std::function<void()>* Heartbeat = nullptr;
};

} // namespace surfsynth
