// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Preconditioned conjugate gradients for several right-hand sides. Private to the solvers.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Solvers/MultigridCycle.h"
#include "Core/Solvers/MultigridHierarchy.h"

#include <array>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Limits of the iterations.
struct IterationLimits
{
  double Tolerance;   ///< largest relative residual
  int MostIterations; ///< of a column
};

/// Outcome of a solve.
struct IterationReport
{
  int Iterations = 0;            ///< largest number of a column
  double RelativeResidual = 0.0; ///< largest of a column, of the final residual as computed from its definition
};

/// Conjugate gradients [Hestenes1952] for @p Columns right-hand sides at once, each with its own coefficients, so that
/// every column has the bits that it has alone. Coefficients are those of a preconditioner that may vary slightly
/// [Golub1999], as one in single precision does. Sums are taken in chunks of fixed size.
///
/// The residual of the recurrence drifts from b - A x. When it reaches the tolerance, b - A x is computed, and where
/// that has not reached it the column goes on from there.
template <int Columns>
class ConjugateGradients
{
public:
  ConjugateGradients(const MultigridHierarchy& hierarchy, const IterationLimits& limits);

  /// Right-hand sides, [V, Columns], to be filled before Run(); the solutions after it.
  double* Block() { return this->RightHandSide.data(); }
  /// Solves in place.
  /// @throws SolverFailure, Cancelled
  IterationReport Run(const Progress& progress);

  /// Bytes of all vectors for @p rows rows, of which the levels together have @p rowsOfLevels.
  static std::int64_t Bytes(std::int64_t rows, std::int64_t rowsOfLevels)
  {
    return 5 * static_cast<std::int64_t>(sizeof(double)) * Columns * rows +
      MultigridCycle<Columns>::Bytes(rowsOfLevels);
  }

private:
  using Numbers = std::array<double, Columns>;

  template <std::size_t Count, typename Body>
  std::array<double, Count> SumOf(const Body& body);
  template <typename Body>
  Numbers Sum(const Body& body)
  {
    return this->template SumOf<Columns>(body);
  }
  void Begin();
  void Precondition();
  Numbers TurnDirection();
  void Advance(const Numbers& step);
  void CheckCandidates();
  void RequirePositive(double product) const;
  void ThrowNotConverged(std::size_t column) const;
  void Beat();

  const MultigridHierarchy& Hierarchy;
  const IterationLimits Limits;
  MultigridCycle<Columns> Cycle;
  LargeArray<double> RightHandSide;
  LargeArray<double> Solution;
  LargeArray<double> Residual;
  LargeArray<double> Direction;
  LargeArray<double> Product; ///< A times Direction

  Numbers Unit{};      ///< powers of two that the right-hand sides are divided by
  Numbers Norm{};      ///< of the right-hand sides
  Numbers Scale{};     ///< powers of two that bring the right-hand sides into the range of single precision
  Numbers Norms{};     ///< of the residuals
  Numbers Projected{}; ///< products of the residual and the preconditioned one
  Numbers Step{};      ///< of the last iteration
  Numbers Checked{};   ///< residuals at the last check
  std::array<bool, Columns> Active{};
  std::array<bool, Columns> Restarted{};
  int Iteration = 0;
  Progress Callback;
  double Fraction = 0.0;
};

} // namespace surfsynth
