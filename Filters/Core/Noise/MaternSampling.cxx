// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternFieldInternals.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
constexpr double LargestResidual = 1e-8;

NormalKey Key(const SampleRequest& request, const MaternColumn& column)
{
  NormalKey key;
  key.Seed = request.Seed;
  key.Sample = column.Sample;
  key.Component = column.Component;
  key.Stream = request.Stream;
  return key;
}
} // namespace

void MaternField::Internals::SampleColumns(const SampleRequest& request, const std::vector<MaternColumn>& columns,
  LargeArray<double>& scratch, const Progress& progress)
{
  if (this->InUse())
  {
    this->SampleBySolve(request, columns, scratch, progress);
    return;
  }
  Eigen::VectorXd values(this->Mass.size());
  for (std::size_t k = 0; k < columns.size(); ++k)
  {
    const NormalKey key = Key(request, columns[k]);
    if (this->Pairs.Values.size() > 0)
    {
      this->SampleBySpectrum(key, values);
    }
    else
    {
      this->SampleByVertex(key, values);
    }
    Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<>>(
      columns[k].Values, values.size(), Eigen::InnerStride<>(request.NumberOfComponents)) = request.Scale * values;
    Report(progress, (k + 1.0) / static_cast<double>(columns.size()));
  }
}

void MaternField::Internals::SampleByVertex(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const
{
  FillNormals(key, 0, values.size(), values.data());
  for (Index v = 0; v < values.size(); ++v)
  {
    const double scale = this->Options.Model == NoiseModel::White ? this->Amplitude[v] / this->RootMass[v]
                                                                  : this->Amplitude[v];
    values[v] = this->Used(v) ? scale * values[v] : 0.0;
  }
}

void MaternField::Internals::SampleBySpectrum(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const
{
  // chi_i / (lambda_i + tau)^(alpha / 2), then one eigenvector after the other, in a fixed order.
  Eigen::VectorXd coefficients(this->Pairs.Values.size());
  FillNormals(key, 0, coefficients.size(), coefficients.data());
  const Eigen::ArrayXd shifted = this->Pairs.Values.array() + this->Tau;
  for (int k = 0; k < this->WholePower() / 2; ++k)
  {
    coefficients.array() /= shifted;
  }
  const double rest = std::fmod(this->Power(), 2.0);
  if (rest == 1.0)
  {
    coefficients.array() /= shifted.sqrt();
  }
  else if (rest != 0.0)
  {
    coefficients.array() /= shifted.pow(0.5 * rest);
  }
  values.setZero();
  for (Eigen::Index i = 0; i < coefficients.size(); ++i)
  {
    values += coefficients[i] * this->Pairs.Vectors.col(i);
  }
  values.array() *= this->Amplitude.array();
}

Eigen::VectorXd MaternField::Internals::NoiseWeights() const
{
  // For odd powers the covariance of the right-hand sides comes from the factor.
  return std::fmod(this->Power(), 2.0) != 1.0 ? this->RootMass
                                              : Eigen::VectorXd((this->Mass.array() > 0.0).cast<double>());
}

double MaternField::Internals::SmallestRangeFactor() const
{
  const MaternFieldArrays& arrays = this->Options.Arrays;
  const double ratio = arrays.Directions.size() > 0 ? this->Options.AnisotropyRatio : 1.0;
  const double least = arrays.RangeFactors.size() > 0 ? arrays.RangeFactors.minCoeff() : 1.0;
  return std::min(1.0, least) * std::sqrt(std::min(ratio, 1.0 / ratio));
}

void MaternField::Internals::ChooseNoise(const FieldDomain& domain)
{
  if (this->Options.CoherentNoise)
  {
    constexpr double SidesOfRange = 14.0;
    const double range = std::sqrt(8.0 * this->Smoothness() / this->Tau) * this->SmallestRangeFactor();
    // A power of sqrt(2), so that triangulations with slightly different ranges have the same lattice.
    this->Lattice = domain.Lattice(std::exp2(0.5 * std::floor(2.0 * std::log2(range / SidesOfRange))));
  }
}

void MaternField::Internals::FillFromLattice(
  const SampleRequest& request, const std::vector<MaternColumn>& columns, Block& block) const
{
  std::vector<NormalKey> keys;
  for (const MaternColumn& column : columns)
  {
    keys.push_back(Key(request, column));
  }
  const LatticeNoise::Rows loads = this->Lattice->Draw(keys);
  block.setZero();
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Mass[v] > 0.0)
    {
      block.row(this->RowOfVertex[v]).head(loads.cols()) = loads.row(v);
    }
  }
}

void MaternField::Internals::FillRightHandSides(
  const SampleRequest& request, const std::vector<MaternColumn>& columns, Block& block) const
{
  if (this->Lattice)
  {
    this->FillFromLattice(request, columns, block);
    return;
  }
  constexpr Index Tile = 256;       // vertices whose numbers for all columns stay in cache
  constexpr Index Pitch = Tile + 8; // no power of two: columns would lie in the same sets of the cache
  const Eigen::VectorXd weights = this->NoiseWeights();
  std::vector<double> normals(Pitch * columns.size());
  for (Index begin = 0; begin < this->Mass.size(); begin += Tile)
  {
    const Index count = std::min<Index>(Tile, static_cast<Index>(this->Mass.size()) - begin);
    for (std::size_t k = 0; k < columns.size(); ++k)
    {
      FillNormals(Key(request, columns[k]), begin, count, normals.data() + k * Pitch);
    }
    for (Index v = begin; v < begin + count; ++v)
    {
      double* row = block.data() + this->RowOfVertex[v] * block.cols();
      const double weight = weights[v];
      const double* normal = normals.data() + (v - begin);
      for (std::size_t k = 0; k < columns.size(); ++k)
      {
        row[k] = weight * normal[k * Pitch];
      }
      std::fill(row + columns.size(), row + block.cols(), 0.0);
    }
  }
}

void MaternField::Internals::RemoveMeans(
  Block& block, const Eigen::VectorXd& weights, const Eigen::VectorXd& shape) const
{
  RowMatrix means = RowMatrix::Zero(this->Components.Count, block.cols());
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Used(v))
    {
      const Index c = this->Components.OfVertex[v];
      means.row(c) += weights[v] / this->Components.Area[c] * block.row(this->RowOfVertex[v]);
    }
  }
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Used(v))
    {
      block.row(this->RowOfVertex[v]) -= shape[v] * means.row(this->Components.OfVertex[v]);
    }
  }
}

Eigen::VectorXd MaternField::Internals::FirstColumn(const Block& block) const
{
  Eigen::VectorXd column(block.rows());
  for (Index v = 0; v < column.size(); ++v)
  {
    column[v] = block(this->RowOfVertex[v], 0);
  }
  return column;
}

void MaternField::Internals::CheckSolution(
  const LinearSolver& solver, const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide)
{
  const double residual = solver.RelativeResidual(solution, rightHandSide);
  if (!(residual <= LargestResidual))
  {
    throw SolverFailure("MaternField: the relative residual of the solve is " + FormatNumber(residual) +
      "; expected at most 1e-8. Needle triangles, or a screening term that is tiny for the size of the mesh, make the "
      "system ill-conditioned: remesh, or use a smaller correlation range.");
  }
  std::lock_guard<std::mutex> lock(this->ResidualMutex);
  this->Residual = std::max(this->Residual, residual);
}

void MaternField::Internals::TakeSolutions(
  const SampleRequest& request, const std::vector<MaternColumn>& columns, const Block& block) const
{
  constexpr Index Tile = 64; // vertices whose rows stay in cache while they are turned into columns
  const auto stride = static_cast<std::ptrdiff_t>(request.NumberOfComponents);
  const auto points = static_cast<Index>(block.rows());
  bool finite = true;
  for (Index begin = 0; begin < points; begin += Tile)
  {
    const Index end = std::min<Index>(begin + Tile, points);
    for (std::size_t k = 0; k < columns.size(); ++k)
    {
      const double* solution = block.data() + k;
      double sum = 0.0;
      for (Index v = begin; v < end; ++v)
      {
        const double value = request.Scale * this->Amplitude[v] * solution[this->RowOfVertex[v] * block.cols()];
        columns[k].Values[v * stride] = value;
        sum += value;
      }
      finite = finite && std::isfinite(sum);
    }
  }
  if (!finite)
  {
    throw SolverFailure("MaternField: a sample is not finite.");
  }
}

void MaternField::Internals::MultiplyByMass(Block& block) const
{
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    block.row(this->RowOfVertex[v]) *= this->Mass[v];
  }
}

void MaternField::Internals::SolveChecked(Block& block, const Progress& progress)
{
  const Eigen::VectorXd rightHandSide = this->FirstColumn(block);
  this->InUse()->SolveOrderedInPlace(block, progress);
  this->CheckSolution(*this->InUse(), this->FirstColumn(block), rightHandSide);
}

void MaternField::Internals::SolveFraction(Block& block, const Progress& progress)
{
  const Eigen::VectorXd rightHandSide = this->FirstColumn(block);
  const auto check = [&](const LinearSolver& solver, const Eigen::VectorXd& solution) {
    this->CheckSolution(solver, solution, rightHandSide);
  };
  this->Fraction->SolveOrderedInPlace(block, this->RowOfVertex, check, progress);
}

void MaternField::Internals::SolvePowers(Block& block, const Progress& progress)
{
  if (this->Fraction)
  {
    const bool hasWhole = this->Power() > 2.0;
    const double share = hasWhole ? 0.9 : 1.0;
    this->SolveFraction(block, SubProgress(progress, 0.0, share));
    if (hasWhole)
    {
      this->MultiplyByMass(block);
      this->SolveChecked(block, SubProgress(progress, share, 1.0));
    }
    return;
  }
  // Covariance A^-1 M A^-1 for alpha = 2 and A^-1 for alpha = 1; each further solve adds two to alpha.
  const int solves = (this->WholePower() - 1) / 2;
  const auto step = [&](int k) { return SubProgress(progress, k / (solves + 1.0), (k + 1) / (solves + 1.0)); };
  if (this->WholePower() % 2 == 0)
  {
    this->SolveChecked(block, step(0));
  }
  else
  {
    this->Solver->SolveTransposedOrderedInPlace(block, step(0));
  }
  for (int k = 1; k <= solves; ++k)
  {
    this->MultiplyByMass(block);
    this->SolveChecked(block, step(k));
  }
}

void MaternField::Internals::SampleBySolve(const SampleRequest& request, const std::vector<MaternColumn>& columns,
  LargeArray<double>& scratch, const Progress& progress)
{
  const auto count = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index padded = this->InUse()->PaddedCount(count);
  const Eigen::Index points = this->Mass.size();
  const auto size = static_cast<std::size_t>(points * padded);
  if (scratch.size() < size)
  {
    scratch = LargeArray<double>(size);
  }
  Block block(scratch.data(), points, padded);
  this->FillRightHandSides(request, columns, block);
  const bool unscreened = this->Options.Model == NoiseModel::Unscreened;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(unscreened ? points : 0);
  if (unscreened)
  {
    this->RemoveMeans(block, ones, this->Mass); // now orthogonal to constants
  }
  this->SolvePowers(block, progress);
  if (unscreened)
  {
    this->RemoveMeans(block, this->Mass, ones);
  }
  this->TakeSolutions(request, columns, block);
}

} // namespace surfsynth
