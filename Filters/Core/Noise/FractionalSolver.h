// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Fractional inverse powers of an operator, as a sum of solves. Private to the noise.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Noise/RationalPower.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/MultigridSolver.h"

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Interval that holds the eigenvalues of M^-1 A for rows of mass above 0.
/// @param lower known lower bound, > 0
/// @return the upper bound of Gershgorin, at least twice @p lower
double LargestEigenvalueBound(const SparseMatrix& matrix, const Eigen::VectorXd& mass, double lower);

/// S = M^-1/2 r(B) M^-1/2 = sum_k w_k (A + c_k M)^-1 with B = M^-1/2 A M^-1/2 and the approximation r of a power [Bolin2020].
class FractionalSolver
{
public:
  /// Factors, or builds a hierarchy for, every A + c_k M.
  /// @param iterative true for conjugate gradients
  FractionalSolver(const SparseMatrix& matrix, const Eigen::VectorXd& mass, RationalPower power, bool iterative,
    const Progress& progress);

  /// Receives each solver with its solution of the first column, in the order of vertices.
  using Check = std::function<void(const LinearSolver& solver, const Eigen::VectorXd& solution)>;

  /// Replaces right-hand sides by S times them.
  /// @param rows row of each vertex
  void SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const std::vector<Index>& rows, const Check& check,
    const Progress& progress) const;
  /// Does the same for rows in the order of vertices.
  void SolveInPlace(RowMatrix& rightHandSides) const;

  /// Adds the shifted part of the diagonal of M^-1/2 B^(-2 whole) r(B)^2 M^-1/2 in partial fractions, and returns the
  /// factors of the diagonals of A^-1 and A^-1 M A^-1, the rest of it. Needs factors.
  /// @param whole 0 or 1
  Eigen::Vector2d AddSquareDiagonal(
    const Eigen::VectorXd& mass, int whole, Eigen::VectorXd& diagonal, const Progress& progress) const;

  const RationalPower& Power() const { return this->Approximation; }
  /// The solver of the first term.
  const LinearSolver& First() const { return this->Terms.front().Get(); }
  bool IsIterative() const { return this->Terms.front().Iterative.has_value(); }
  /// Largest number of iterations of a solve so far; 0 for factors.
  int Iterations() const;

private:
  struct Term
  {
    std::optional<CholeskySolver> Factor;
    std::optional<MultigridSolver> Iterative;

    const LinearSolver& Get() const
    {
      return this->Iterative ? static_cast<const LinearSolver&>(*this->Iterative) : *this->Factor;
    }
  };

  RationalPower Approximation;
  std::vector<Term> Terms;
};

} // namespace surfsynth
