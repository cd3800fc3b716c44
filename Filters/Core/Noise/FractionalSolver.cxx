// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/FractionalSolver.h"

#include "Core/Noise/MaternFieldInternals.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

double LargestEigenvalueBound(const SparseMatrix& matrix, const Eigen::VectorXd& mass, double lower)
{
  double largest = 2.0 * lower;
  for (Index column = 0; column < matrix.cols(); ++column)
  {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry)
    {
      sum += std::abs(entry.value());
    }
    largest = mass[column] > 0.0 ? std::max(largest, sum / mass[column]) : largest;
  }
  return largest;
}

FractionalSolver::FractionalSolver(const SparseMatrix& matrix, const Eigen::VectorXd& mass, RationalPower power,
  bool iterative, const Progress& progress)
  : Approximation(std::move(power))
  , Terms(this->Approximation.Shifts.size())
{
  const auto count = static_cast<double>(this->Terms.size());
  for (std::size_t k = 0; k < this->Terms.size(); ++k)
  {
    SparseMatrix shifted = matrix;
    AddToDiagonal(shifted, this->Approximation.Shifts[k] * mass);
    const Progress part = SubProgress(progress, static_cast<double>(k) / count, (static_cast<double>(k) + 1.0) / count);
    if (iterative)
    {
      this->Terms[k].Iterative.emplace(std::move(shifted), MultigridOptions(), part);
    }
    else
    {
      this->Terms[k].Factor.emplace(shifted, part);
    }
  }
}

void FractionalSolver::SolveOrderedInPlace(Eigen::Ref<RowMatrix> rightHandSides, const std::vector<Index>& rows,
  const Check& check, const Progress& progress) const
{
  const Eigen::Index points = rightHandSides.rows();
  const auto count = static_cast<double>(this->Terms.size());
  RowMatrix sum = RowMatrix::Zero(points, rightHandSides.cols());
  RowMatrix term(points, rightHandSides.cols());
  Eigen::VectorXd first(points);
  for (std::size_t k = 0; k < this->Terms.size(); ++k)
  {
    const LinearSolver& solver = this->Terms[k].Get();
    const std::vector<Index>& order = solver.Order();
    for (Eigen::Index row = 0; row < points; ++row)
    {
      term.row(row) = rightHandSides.row(rows[order[row]]);
    }
    solver.SolveOrderedInPlace(
      term, SubProgress(progress, static_cast<double>(k) / count, (static_cast<double>(k) + 1.0) / count));
    for (Eigen::Index row = 0; row < points; ++row)
    {
      sum.row(rows[order[row]]) += this->Approximation.Weights[k] * term.row(row);
      first[order[row]] = term(row, 0);
    }
    check(solver, first);
  }
  rightHandSides = sum;
}

void FractionalSolver::SolveInPlace(RowMatrix& rightHandSides) const
{
  RowMatrix sum = RowMatrix::Zero(rightHandSides.rows(), rightHandSides.cols());
  for (std::size_t k = 0; k < this->Terms.size(); ++k)
  {
    RowMatrix term = rightHandSides;
    this->Terms[k].Get().SolveInPlace(term);
    sum += this->Approximation.Weights[k] * term;
  }
  rightHandSides = std::move(sum);
}

Eigen::Vector2d FractionalSolver::AddSquareDiagonal(
  const Eigen::VectorXd& mass, int whole, Eigen::VectorXd& diagonal, const Progress& progress) const
{
  // With g(x) = x^(-2 whole): r^2 g has the coefficients w^2 g(-c) of 1 / (x + c)^2 and b g(-c) + w^2 g'(-c) of
  // 1 / (x + c), b = 2 w sum_j w_j / (c_j - c) over the others; and r(0)^2 of 1 / x^2, 2 r(0) r'(0) of 1 / x.
  const std::vector<double>& w = this->Approximation.Weights;
  const std::vector<double>& c = this->Approximation.Shifts;
  const auto count = static_cast<double>(w.size());
  double value = 0.0;
  double derivative = 0.0;
  for (std::size_t k = 0; k < w.size(); ++k)
  {
    double others = 0.0;
    for (std::size_t j = 0; j < w.size(); ++j)
    {
      others += j == k ? 0.0 : 2.0 * w[k] * w[j] / (c[j] - c[k]);
    }
    value += w[k] / c[k];
    derivative -= w[k] / (c[k] * c[k]);
    const double g = whole > 0 ? 1.0 / (c[k] * c[k]) : 1.0;
    const double slope = whole > 0 ? 2.0 / (c[k] * c[k] * c[k]) : 0.0;
    const Eigen::MatrixXd diagonals = this->Terms[k].Factor->InverseDiagonals(
      mass, 2, SubProgress(progress, static_cast<double>(k) / count, (static_cast<double>(k) + 1.0) / count));
    diagonal += (others * g + w[k] * w[k] * slope) * diagonals.col(0) + w[k] * w[k] * g * diagonals.col(1);
  }
  return whole > 0 ? Eigen::Vector2d(2.0 * value * derivative, value * value) : Eigen::Vector2d::Zero();
}

int FractionalSolver::Iterations() const
{
  int iterations = 0;
  for (const Term& term : this->Terms)
  {
    iterations = std::max(iterations, term.Iterative ? term.Iterative->Iterations() : 0);
  }
  return iterations;
}

} // namespace surfsynth
