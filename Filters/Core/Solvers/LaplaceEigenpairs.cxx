// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/LaplaceEigenpairs.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/CholeskySolver.h"

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
  {
  }
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

/// Scatters to all vertices, ascending, each with its largest entry positive.
Eigenpairs Collect(const UsedPart& part, const Eigen::VectorXd& values, const Eigen::MatrixXd& vectors, Eigen::Index rows)
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    order[k] = static_cast<Eigen::Index>(k);
  }
  std::stable_sort(
    order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  Eigenpairs pairs{ Eigen::VectorXd(values.size()), Eigen::MatrixXd::Zero(rows, values.size()) };
  for (Eigen::Index k = 0; k < values.size(); ++k)
  {
    pairs.Values[k] = std::max(values[order[k]], 0.0);
    const Eigen::VectorXd vector = vectors.col(order[k]).cwiseQuotient(part.RootMass);
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
}

Eigenpairs LowestLaplaceEigenpairs(
  const SparseMatrix& stiffness, const Eigen::VectorXd& mass, Index count, const Progress& progress)
{
  // The lowest eigenvalues are about 4 pi k / area (Weyl): a shift well below the first one that is not zero.
  const double area = mass.sum();
  const double shift = 0.1 * 4.0 * M_PI / (area > 0.0 ? area : 1.0);
  const UsedPart part = Restrict(stiffness, mass, shift);
  const Eigen::Index size = part.RootMass.size();
  if (count < 1 || count >= size)
  {
    throw InvalidInput("LowestLaplaceEigenpairs: " + std::to_string(count) + " eigenpairs asked for; expected 1 to " +
      std::to_string(size - 1) + ", one less than the number of vertices in use.");
  }
  const Eigen::Index basis = std::min<Eigen::Index>(size, std::max<Eigen::Index>(2 * count, 20));
  ShiftedInverse inverse(part, 2.0 * static_cast<double>(basis), progress);
  Spectra::SymEigsShiftSolver<ShiftedInverse> solver(inverse, count, basis, -shift);
  solver.init();
  constexpr Eigen::Index MaximumIterations = 1000;
  const Eigen::Index converged = solver.compute(Spectra::SortRule::LargestMagn, MaximumIterations, 1e-10);
  if (solver.info() != Spectra::CompInfo::Successful || converged < count)
  {
    throw SolverFailure("LowestLaplaceEigenpairs: " + std::to_string(converged) + " of " + std::to_string(count) +
      " eigenpairs converged to 1e-10.");
  }
  Report(progress, 1.0);
  return Collect(part, solver.eigenvalues(), solver.eigenvectors(), stiffness.rows());
}

} // namespace surfsynth
