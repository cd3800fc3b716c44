// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/RepeatedCholesky.h"

#include "Core/Common/Errors.h"

#ifdef SURFACE_SYNTHESIS_CHOLMOD
#include "Core/Common/Parallel.h"
#include "Core/Solvers/SupernodalFactor.h"
#else
#include <Eigen/SparseCholesky>

#include <string>
#endif

namespace surfsynth
{

#ifdef SURFACE_SYNTHESIS_CHOLMOD
class RepeatedCholesky::Internals
{
public:
  explicit Internals(const SparseMatrix& matrix)
    : Analysis(AnalyzeSupernodes(matrix))
  {}

  Eigen::VectorXd Solve(
    const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide, const Progress& progress) const
  {
    const ThreadScope oneThread(1);
    const SupernodalFactor factor(this->Analysis, matrix, progress);
    Eigen::VectorXd ordered(rightHandSide.size());
    for (Eigen::Index row = 0; row < ordered.size(); ++row)
    {
      ordered[row] = rightHandSide[this->Analysis.OldOfNew[row]];
    }
    factor.SolveInPlace(ordered.data(), 1, {});
    Eigen::VectorXd solution(ordered.size());
    for (Eigen::Index row = 0; row < ordered.size(); ++row)
    {
      solution[this->Analysis.OldOfNew[row]] = ordered[row];
    }
    return solution;
  }

private:
  SupernodalAnalysis Analysis;
};
#else
class RepeatedCholesky::Internals
{
public:
  explicit Internals(const SparseMatrix& matrix) { this->Solver.analyzePattern(matrix); }

  Eigen::VectorXd Solve(const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide, const Progress& progress)
  {
    Report(progress, 0.0);
    this->Solver.factorize(matrix);
    if (this->Solver.info() != Eigen::Success)
    {
      throw SolverFailure("RepeatedCholesky: the matrix of size " + std::to_string(matrix.rows()) +
        " is not positive definite; expected a symmetric positive definite matrix.");
    }
    return this->Solver.solve(rightHandSide);
  }

private:
  Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower> Solver;
};
#endif

RepeatedCholesky::RepeatedCholesky(const SparseMatrix& matrix)
  : Impl(std::make_unique<Internals>(matrix))
{}

RepeatedCholesky::~RepeatedCholesky() = default;
RepeatedCholesky::RepeatedCholesky(RepeatedCholesky&&) noexcept = default;
RepeatedCholesky& RepeatedCholesky::operator=(RepeatedCholesky&&) noexcept = default;

Eigen::VectorXd RepeatedCholesky::Solve(
  const SparseMatrix& matrix, const Eigen::VectorXd& rightHandSide, const Progress& progress)
{
  return this->Impl->Solve(matrix, rightHandSide, progress);
}

} // namespace surfsynth
