// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternFieldInternals.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <cmath>
#include <string>

namespace surfsynth
{

// With D the amplitudes and A, M the operator and the mass, all restricted to the free vertices,
//   C = D A^-1 (M A^-1)^(alpha - 1) D,   Q = D^-1 A (M^-1 A)^(alpha - 1) D^-1.
// For alpha without a whole number, C = D R M R D with R = A^-1 M S for alpha > 2, R = S for alpha < 2: see FractionalSolver.

void MaternField::Internals::RequireAlgebra(Eigen::Index rows) const
{
  if (this->Options.Model != NoiseModel::Matern)
  {
    throw InvalidInput("MaternField: covariance and precision of another noise model asked for; expected Matern.");
  }
  if (rows != this->Mass.size())
  {
    throw InvalidInput("MaternField: the vectors have " + std::to_string(rows) + " rows; expected " +
      std::to_string(this->Mass.size()) + ".");
  }
}

void MaternField::Internals::RequireFactor(const char* use) const
{
  if (this->IsIterative())
  {
    throw InvalidInput(std::string("MaternField: ") + use +
      " of a field whose Cholesky factor exceeds the limit of memory asked for; expected one that fits.");
  }
}

void MaternField::Internals::RequireWholePower(const char* use) const
{
  if (this->IsFractional())
  {
    throw InvalidInput(std::string("MaternField: ") + use + " of a field of operator power " +
      FormatNumber(this->Power()) + "; expected the power 1, 2, 3 or 4.");
  }
}

Eigen::VectorXd MaternField::Internals::InverseAmplitude() const
{
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(this->Mass.size());
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Mass[v] > 0.0)
    {
      inverse[v] = 1.0 / this->Amplitude[v];
      if (!std::isfinite(inverse[v]))
      {
        throw InvalidInput("MaternField: the precision of a field of standard deviation 0 asked for; expected one "
                           "above 0.");
      }
    }
  }
  return inverse;
}

void MaternField::Internals::ApplyRoot(RowMatrix& values) const
{
  this->Fraction->SolveInPlace(values);
  if (const LinearSolver* whole = this->OfWholePower())
  {
    values = this->Mass.asDiagonal() * values;
    whole->SolveInPlace(values);
  }
}

void MaternField::Internals::ApplyCovariance(RowMatrix& values) const
{
  this->RequireAlgebra(values.rows());
  const Eigen::VectorXd amplitude = (this->Mass.array() > 0.0).select(this->Amplitude, 0.0);
  values = amplitude.asDiagonal() * values;
  if (this->Fraction)
  {
    this->ApplyRoot(values);
    values = this->Mass.asDiagonal() * values;
    this->ApplyRoot(values);
  }
  else if (const LinearSolver* solver = this->InUse())
  {
    solver->SolveInPlace(values);
    for (int k = 1; k < this->WholePower(); ++k)
    {
      values = this->Mass.asDiagonal() * values;
      solver->SolveInPlace(values);
    }
  }
  values = amplitude.asDiagonal() * values;
}

void MaternField::Internals::ApplyPrecision(RowMatrix& values) const
{
  this->RequireAlgebra(values.rows());
  this->RequireWholePower("the precision");
  const Eigen::VectorXd scale = this->InverseAmplitude();
  const Eigen::VectorXd inverseMass = (this->Mass.array() > 0.0).select(this->Mass.cwiseInverse(), 0.0);
  values = scale.asDiagonal() * values;
  for (int k = 0; k < this->Power() && this->InUse(); ++k)
  {
    if (k > 0)
    {
      values = inverseMass.asDiagonal() * values;
    }
    values = this->Iterative ? this->Iterative->Multiply(values) : RowMatrix(this->Solver->Matrix() * values);
  }
  values = scale.asDiagonal() * values;
}

double MaternField::Internals::LogDeterminantOfPrecision() const
{
  this->RequireAlgebra(this->Mass.size());
  this->RequireFactor("determinants");
  this->RequireWholePower("determinants");
  const Eigen::VectorXd scale = this->InverseAmplitude();
  double sum = this->Solver ? this->Power() * this->Solver->LogDeterminant() : 0.0;
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Mass[v] > 0.0)
    {
      sum += 2.0 * std::log(scale[v]) - (this->Power() - 1) * std::log(this->Mass[v]);
    }
  }
  return sum;
}

void MaternField::Internals::RequireRoomForInverse() const
{
  if (!this->InUse() || this->Options.VarianceCorrection) // then there was room when the field was made
  {
    return;
  }
  // Selected inversion holds two more factors for each power; with a limit that is given, that of the field counts, too.
  const SparseMatrix& matrix = static_cast<const CholeskySolver*>(this->InUse())->Matrix();
  const std::uint64_t held = this->Options.FactorMemoryLimit > 0 ? this->NumberOfFactors() : 0U;
  const std::uint64_t powers = this->Rational ? 2U : static_cast<std::uint64_t>(this->WholePower());
  const std::uint64_t factors = held + 2U * powers;
  const std::uint64_t needed = factors * CholeskySolver::EstimateMemory(matrix.rows(), matrix.nonZeros());
  const std::uint64_t limit = this->FactorLimit();
  if (needed > limit)
  {
    constexpr std::uint64_t MiB = 1U << 20U;
    throw InvalidInput("MaternField: variances take about " + std::to_string(needed / MiB + 1) +
      " MiB for the factors of the inverse; expected at most " + std::to_string(limit / MiB) +
      " MiB. Raise the memory limit, or leave out the variances.");
  }
}

Eigen::VectorXd MaternField::Internals::MarginalVariances(const Progress& progress) const
{
  this->RequireAlgebra(this->Mass.size());
  this->RequireFactor("variances");
  this->RequireRoomForInverse();
  return this->InverseVariances(progress);
}

Eigen::VectorXd MaternField::Internals::InverseDiagonal(const Progress& progress) const
{
  if (!this->Fraction)
  {
    return this->Solver->InverseDiagonals(this->Mass, this->WholePower(), progress).col(this->WholePower() - 1);
  }
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(this->Mass.size());
  const double share = this->Solver ? 0.9 : 1.0;
  const Eigen::Vector2d rest = this->Fraction->AddSquareDiagonal(
    this->Mass, this->Solver ? 1 : 0, diagonal, SubProgress(progress, 0.0, share));
  if (this->Solver)
  {
    diagonal += this->Solver->InverseDiagonals(this->Mass, 2, SubProgress(progress, share, 1.0)) * rest;
  }
  return diagonal;
}

Eigen::VectorXd MaternField::Internals::InverseVariances(const Progress& progress) const
{
  if (!this->InUse())
  {
    return Eigen::VectorXd::Zero(this->Mass.size());
  }
  const Eigen::VectorXd variances = this->Amplitude.cwiseAbs2().cwiseProduct(this->InverseDiagonal(progress));
  return (this->Mass.array() > 0.0).select(variances, 0.0);
}

Eigen::MatrixXd MaternField::SolvePrecision(const Eigen::Ref<const Eigen::MatrixXd>& rightHandSides) const
{
  RowMatrix values = rightHandSides;
  this->Impl->ApplyCovariance(values);
  return values;
}

Eigen::MatrixXd MaternField::ApplyPrecision(const Eigen::Ref<const Eigen::MatrixXd>& values) const
{
  RowMatrix result = values;
  this->Impl->ApplyPrecision(result);
  return result;
}

double MaternField::LogDeterminantOfPrecision() const { return this->Impl->LogDeterminantOfPrecision(); }

Eigen::VectorXd MaternField::MarginalVariances(const Progress& progress) const
{
  return this->Impl->MarginalVariances(progress);
}

} // namespace surfsynth
