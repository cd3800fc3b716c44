// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/LaplaceEigenpairs.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsShiftSolver.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace surfsynth
{

namespace
{
/// The vertices with mass, and the operators restricted to them.
struct UsedPart
{
  std::vector<Index> Vertices;
  Eigen::VectorXd RootMass; ///< square roots of their masses
  SparseMatrix Shifted;     ///< L + shift M
};

UsedPart Restrict(const SparseMatrix& stiffness, const Eigen::VectorXd& mass, double shift)
{
  UsedPart part;
  std::vector<Index> place(static_cast<std::size_t>(mass.size()), -1);
  for (Index v = 0; v < mass.size(); ++v)
  {
    if (mass[v] > 0.0)
    {
      place[v] = static_cast<Index>(part.Vertices.size());
      part.Vertices.push_back(v);
    }
  }
  const auto count = static_cast<Index>(part.Vertices.size());
  part.RootMass.resize(count);
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(static_cast<std::size_t>(stiffness.nonZeros()) + part.Vertices.size());
  for (Index k = 0; k < count; ++k)
  {
    const Index v = part.Vertices[k];
    part.RootMass[k] = std::sqrt(mass[v]);
    entries.emplace_back(k, k, shift * mass[v]);
    for (SparseMatrix::InnerIterator entry(stiffness, v); entry; ++entry)
    {
      if (place[entry.row()] >= 0)
      {
        entries.emplace_back(place[entry.row()], k, entry.value());
      }
    }
  }
  part.Shifted.resize(count, count);
  part.Shifted.setFromTriplets(entries.begin(), entries.end());
  return part;
}

/// x -> M^1/2 (L + shift M)^-1 M^1/2 x, whose largest eigenvalues are 1 / (lambda + shift).
class ShiftedInverse
{
public:
  using Scalar = double;

  ShiftedInverse(const UsedPart& part, double expectedProducts, Progress progress)
    : Part(part)
    , Solver(part.Shifted, SubProgress(progress, 0.0, 0.2))
    , Expected(expectedProducts)
    , OnProgress(SubProgress(progress, 0.2, 1.0))
  {}
  Eigen::Index rows() const { return this->Part.RootMass.size(); }
  Eigen::Index cols() const { return this->rows(); }
  void set_shift(double) {} // fixed when the matrix was factored
  void perform_op(const double* in, double* out) const
  {
    Report(this->OnProgress, this->Done / (this->Done + this->Expected));
    this->Done += 1.0;
    const Eigen::Map<const Eigen::VectorXd> x(in, this->rows());
    Eigen::Map<Eigen::VectorXd>(out, this->rows()) = this->Part.RootMass.cwiseProduct(
      this->Solver.Solve(this->Part.RootMass.cwiseProduct(x)));
  }

private:
  const UsedPart& Part;
  CholeskySolver Solver;
  double Expected;
  Progress OnProgress;
  mutable double Done = 0.0;
};

/// The shifted inverse without the eigenpairs that are known: those directions go to 0.
class DeflatedInverse
{
public:
  using Scalar = double;

  DeflatedInverse(
    const ShiftedInverse& inverse, double shift, const Eigen::VectorXd& values, const Eigen::MatrixXd& vectors)
    : Inverse(inverse)
    , Weights((values.array() + shift).inverse().matrix())
    , Vectors(vectors)
  {}
  Eigen::Index rows() const { return this->Inverse.rows(); }
  Eigen::Index cols() const { return this->Inverse.cols(); }
  void set_shift(double) {}
  void perform_op(const double* in, double* out) const
  {
    this->Inverse.perform_op(in, out);
    const Eigen::Map<const Eigen::VectorXd> x(in, this->rows());
    Eigen::Map<Eigen::VectorXd>(out, this->rows()) -= this->Vectors *
      this->Weights.cwiseProduct(this->Vectors.transpose() * x);
  }

private:
  const ShiftedInverse& Inverse;
  Eigen::VectorXd Weights;
  const Eigen::MatrixXd& Vectors;
};

/// Runs Lanczos for the @p count lowest eigenvalues of @p inverse. The start vector depends on @p round: Lanczos sees
/// one direction of each eigenspace, which another start makes another one.
template <typename Inverse>
void Solve(Inverse& inverse, double shift, Eigen::Index count, Eigen::Index basis, std::uint32_t round,
  Eigen::VectorXd& values, Eigen::MatrixXd& vectors)
{
  Spectra::SymEigsShiftSolver<Inverse> solver(inverse, count, basis, -shift);
  Eigen::VectorXd start(inverse.rows());
  NormalKey key;
  key.Sample = round;
  FillNormals(key, 0, start.size(), start.data());
  solver.init(start.data());
  constexpr Eigen::Index MaximumIterations = 1000;
  const Eigen::Index converged = solver.compute(Spectra::SortRule::LargestMagn, MaximumIterations, 1e-10);
  if (solver.info() != Spectra::CompInfo::Successful || converged < count)
  {
    throw SolverFailure("LowestLaplaceEigenpairs: " + std::to_string(converged) + " of " + std::to_string(count) +
      " eigenpairs converged to 1e-10.");
  }
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

/// Looks for eigenvalues below the largest of @p values that a Lanczos run has missed, as it may where symmetry of the
/// surface makes eigenvalues multiple, and appends them; false when there are none.
bool AppendMissed(
  const ShiftedInverse& inverse, double shift, std::uint32_t round, Eigen::VectorXd& values, Eigen::MatrixXd& vectors)
{
  const Eigen::Index size = inverse.rows();
  const Eigen::Index known = values.size();
  const Eigen::Index more = std::min<Eigen::Index>(4, size - known);
  if (more == 0)
  {
    return false;
  }
  const Eigen::Index basis = std::min<Eigen::Index>(size, std::max<Eigen::Index>(known, 20));
  DeflatedInverse deflated(inverse, shift, values, vectors);
  Eigen::VectorXd otherValues;
  Eigen::MatrixXd otherVectors;
  Solve(deflated, shift, more, basis, round, otherValues, otherVectors);
  const double limit = values.maxCoeff() - 1e-9 * (values.maxCoeff() + shift);
  for (Eigen::Index k = 0; k < more; ++k)
  {
    if (otherValues[k] < limit)
    {
      values.conservativeResize(values.size() + 1);
      values[values.size() - 1] = otherValues[k];
      vectors.conservativeResize(size, vectors.cols() + 1);
      vectors.col(vectors.cols() - 1) = otherVectors.col(k);
    }
  }
  return values.size() > known;
}

/// All eigenpairs of a small problem: below a few hundred vertices the dense solver is as fast, and the Krylov space of
/// a very symmetric surface (the tetrahedron has two eigenvalues) ends before Lanczos has begun.
void SolveDense(const UsedPart& part, double shift, Eigen::VectorXd& values, Eigen::MatrixXd& vectors)
{
  const Eigen::VectorXd scale = part.RootMass.cwiseInverse();
  const Eigen::MatrixXd matrix = scale.asDiagonal() * Eigen::MatrixXd(part.Shifted) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success)
  {
    throw SolverFailure("LowestLaplaceEigenpairs: the dense eigensolver did not converge.");
  }
  values = solver.eigenvalues().array() - shift;
  vectors = solver.eigenvectors();
}

/// Scatters the @p count lowest to all vertices, ascending, each with its largest entry positive.
/// @param unit of the eigenvalues
Eigenpairs ScatterLowest(const UsedPart& part, double unit, const Eigen::VectorXd& values,
  const Eigen::MatrixXd& vectors, Eigen::Index count, Eigen::Index rows)
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    order[k] = static_cast<Eigen::Index>(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  Eigenpairs pairs{ Eigen::VectorXd(count), Eigen::MatrixXd::Zero(rows, count) };
  for (Eigen::Index k = 0; k < count; ++k)
  {
    pairs.Values[k] = unit * std::max(values[order[k]], 0.0);
    // Scaled before the largest entry is looked for: rounding decides between entries of equal size.
    const Eigen::VectorXd vector = std::sqrt(unit) * vectors.col(order[k]).cwiseQuotient(part.RootMass);
    Eigen::Index largest = 0;
    vector.cwiseAbs().maxCoeff(&largest);
    const double sign = vector[largest] < 0.0 ? -1.0 : 1.0;
    for (Eigen::Index j = 0; j < vector.size(); ++j)
    {
      pairs.Vectors(part.Vertices[j], k) = sign * vector[j];
    }
  }
  return pairs;
}
} // namespace

Eigenpairs LowestLaplaceEigenpairs(
  const SparseMatrix& stiffness, const Eigen::VectorXd& mass, Index count, const Progress& progress)
{
  // The lowest eigenvalues are about 4 pi k / area (Weyl): a shift well below the first one that is not zero.
  const double area = mass.sum();
  const double shift = 0.1 * 4.0 * M_PI / (area > 0.0 ? area : 1.0);
  // In the unit of the shift, because Spectra's test of convergence has an absolute floor, below which all inverses of
  // small surfaces lie.
  constexpr double Unit = 1.0;
  const UsedPart part = Restrict(stiffness, shift * mass, Unit);
  const Eigen::Index size = part.RootMass.size();
  if (count < 1 || count >= size)
  {
    throw InvalidInput("LowestLaplaceEigenpairs: " + std::to_string(count) + " eigenpairs asked for; expected 1 to " +
      std::to_string(size - 1) + ", one less than the number of vertices in use.");
  }
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  if (size <= 200)
  {
    SolveDense(part, Unit, values, vectors);
  }
  else
  {
    const Eigen::Index basis = std::min<Eigen::Index>(size, std::max<Eigen::Index>(2 * count, 20));
    ShiftedInverse inverse(part, 3.0 * static_cast<double>(basis), progress);
    std::uint32_t round = 0;
    Solve(inverse, Unit, count, basis, round, values, vectors);
    while (AppendMissed(inverse, Unit, ++round, values, vectors))
    {}
  }
  Report(progress, 1.0);
  return ScatterLowest(part, shift, values, vectors, count, stiffness.rows());
}

} // namespace surfsynth
