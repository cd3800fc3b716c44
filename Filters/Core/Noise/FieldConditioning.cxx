// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/FieldConditioning.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Most columns of one product with C.
constexpr Eigen::Index MostTogether = 64;
/// Memory for each vertex and column of a product with C: four blocks. And for each pair of observations: their covariance,
/// its factor, and the copies while it is split.
constexpr double BytesOfVertex = 4.0 * 8.0;
constexpr double BytesOfPair = 32.0;
/// Variance of an exact observation given earlier ones, over its own, below which it follows from them.
constexpr double DependentVariance = 1e-11;
/// ExactAccuracy of exact observations, relative to the largest value.
constexpr double ExactAccuracy = 1e-8;
/// Most corrections of the values at exact observations.
constexpr int MostCorrections = 4;
/// Changes the stream of the errors of observations, so that they may have the key of the sample.
constexpr std::uint32_t StreamOfErrors = 0x6f627365;

void RequireObserved(bool condition, const std::string& text)
{
  if (!condition)
  {
    throw InvalidInput("FieldConditioning: " + text);
  }
}

std::string MebiBytes(double bytes) { return FormatNumber(std::ceil(bytes / 1048576.0)) + " MiB"; }

/// Number of columns of a product with C that fit. @throws InvalidInput as FieldConditioning, where there is no room for 1.
Eigen::Index FittingColumns(Eigen::Index observations, Eigen::Index vertices, std::uint64_t limit)
{
  const double blocks = BytesOfVertex * static_cast<double>(vertices);
  const double needed = BytesOfPair * static_cast<double>(observations) * static_cast<double>(observations) + blocks;
  const auto available = static_cast<double>(limit);
  if (needed > available)
  {
    const double fitting = std::floor(std::sqrt(std::max(0.0, available - blocks) / BytesOfPair));
    throw InvalidInput("FieldConditioning: " + std::to_string(observations) + " observations need " +
      MebiBytes(needed) + "; expected at most " + FormatNumber(fitting) + ", which fit into " + MebiBytes(available) +
      ". Take fewer observations, or raise the memory limit.");
  }
  const double columns = (available - needed + blocks) / std::max(blocks, 1.0);
  return static_cast<Eigen::Index>(std::min(columns, static_cast<double>(MostTogether)));
}

/// Rows of @p matrix.
SparseRowMatrix RowsOf(const SparseRowMatrix& matrix, const std::vector<Index>& rows)
{
  SparseRowMatrix selection(static_cast<Index>(rows.size()), static_cast<Index>(matrix.rows()));
  selection.reserve(Eigen::VectorXi::Constant(static_cast<Index>(rows.size()), 1));
  for (std::size_t k = 0; k < rows.size(); ++k)
  {
    selection.insert(static_cast<Index>(k), rows[k]) = 1.0;
  }
  return selection * matrix;
}

Eigen::MatrixXd RowsOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix, const std::vector<Index>& rows)
{
  Eigen::MatrixXd selected(static_cast<Eigen::Index>(rows.size()), matrix.cols());
  for (std::size_t k = 0; k < rows.size(); ++k)
  {
    selected.row(static_cast<Eigen::Index>(k)) = matrix.row(rows[k]);
  }
  return selected;
}

/// Rows of barycentric coordinates. @p cellOf(place) is the cell of a place, a row of @p cells.
template <typename Cells, typename Places, typename CellOf>
SparseRowMatrix InterpolationRows(
  const Cells& cells, Index points, const Places& places, const std::string& kind, const CellOf& cellOf)
{
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    const Index cell = cellOf(places[i]);
    if (cell < 0 || cell >= cells.rows())
    {
      throw InvalidInput("ObservationMatrix: place " + std::to_string(i) + " is in " + kind + " " +
        std::to_string(cell) + "; expected one of " + std::to_string(cells.rows()) + ".");
    }
    for (int k = 0; k < static_cast<int>(cells.cols()); ++k)
    {
      entries.emplace_back(static_cast<Index>(i), cells(cell, k), places[i].Weights[k]);
    }
  }
  SparseRowMatrix matrix(static_cast<Index>(places.size()), points);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}
} // namespace

SparseRowMatrix ObservationMatrix(const TriangleMesh& mesh, const std::vector<SurfacePlace>& places)
{
  return InterpolationRows(mesh.Triangles, mesh.NumberOfPoints(), places, "triangle",
    [](const SurfacePlace& place) { return place.Triangle; });
}

SparseRowMatrix ObservationMatrix(const TetrahedralMesh& mesh, const std::vector<VolumePlace>& places)
{
  return InterpolationRows(mesh.Tetrahedra, mesh.NumberOfPoints(), places, "tetrahedron",
    [](const VolumePlace& place) { return place.Tetrahedron; });
}

FieldConditioning::FieldConditioning(CovarianceProduct covariance, const SparseRowMatrix& matrix,
  const Eigen::VectorXd& deviations, std::uint64_t memoryLimit, const Progress& progress)
  : Covariance(std::move(covariance))
  , Matrix(matrix)
  , Deviations(deviations)
{
  RequireObserved(deviations.size() == matrix.rows(),
    std::to_string(deviations.size()) + " deviations; expected " + std::to_string(matrix.rows()) + ".");
  RequireObserved(deviations.allFinite() && (deviations.array() >= 0.0).all(),
    "a deviation is negative or not finite; expected numbers of at least 0.");
  this->Together = FittingColumns(matrix.rows(), matrix.cols(), memoryLimit);
  const Eigen::Index count = matrix.rows();
  const SparseRowMatrix transpose = matrix.transpose();
  Eigen::MatrixXd full(count, count);
  for (Eigen::Index first = 0; first < count; first += this->Together)
  {
    const Eigen::Index columns = std::min(this->Together, count - first);
    Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(count, columns);
    chosen.middleRows(first, columns).setIdentity();
    full.middleCols(first, columns) = matrix * this->Covariance(transpose * chosen);
    Report(progress, static_cast<double>(first + columns) / static_cast<double>(count));
  }
  full = (0.5 * (full + full.transpose())).eval();
  full.diagonal() += deviations.cwiseAbs2();
  for (Eigen::Index i = 0; i < count; ++i)
  {
    RequireObserved(full(i, i) > 0.0 && std::isfinite(full(i, i)),
      "the variance of the field at observation " + std::to_string(i) + ", which is exact, is " +
        FormatNumber(full(i, i)) + "; expected a number above 0.");
  }
  this->Factor(full);
}

void FieldConditioning::Factor(const Eigen::MatrixXd& full)
{
  const Eigen::LLT<Eigen::MatrixXd> factor(full);
  this->Root = factor.matrixL();
  const auto independent = [&] {
    return (this->Root.diagonal().cwiseAbs2().array() > DependentVariance * full.diagonal().array()).all();
  };
  if (factor.info() == Eigen::Success && independent())
  {
    for (Index i = 0; i < full.rows(); ++i)
    {
      this->Kept.push_back(i);
    }
    return;
  }
  this->SplitRows(full);
  this->Matrix = RowsOf(this->Matrix, this->Kept);
}

void FieldConditioning::SplitRows(const Eigen::MatrixXd& full)
{
  // The Cholesky factor row by row, without those rows that have no variance given the ones before.
  const Eigen::Index count = full.rows();
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(count, count);
  std::vector<Eigen::VectorXd> dependentRows;
  for (Index i = 0; i < count; ++i)
  {
    const auto kept = static_cast<Eigen::Index>(this->Kept.size());
    Eigen::VectorXd row(kept);
    for (Eigen::Index k = 0; k < kept; ++k)
    {
      row[k] = full(i, this->Kept[static_cast<std::size_t>(k)]);
    }
    root.topLeftCorner(kept, kept).triangularView<Eigen::Lower>().solveInPlace(row);
    const double variance = full(i, i) - row.squaredNorm();
    if (variance > DependentVariance * full(i, i))
    {
      root.row(kept).head(kept) = row.transpose();
      root(kept, kept) = std::sqrt(variance);
      this->Kept.push_back(i);
    }
    else if (this->Deviations[i] == 0.0)
    {
      this->Dependent.push_back(i);
      dependentRows.push_back(std::move(row));
    }
    else
    {
      throw SolverFailure("FieldConditioning: the covariance of the observations is not positive definite at number " +
        std::to_string(i) + "; expected a larger deviation of the observation, or 0.");
    }
  }
  const auto kept = static_cast<Eigen::Index>(this->Kept.size());
  this->Root = root.topLeftCorner(kept, kept);
  this->Prediction = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(dependentRows.size()), kept);
  for (std::size_t d = 0; d < dependentRows.size(); ++d)
  {
    const Eigen::Index length = dependentRows[d].size();
    this->Prediction.row(static_cast<Eigen::Index>(d)).head(length) = this->Root.topLeftCorner(length, length)
                                                                        .triangularView<Eigen::Lower>()
                                                                        .transpose()
                                                                        .solve(dependentRows[d])
                                                                        .transpose();
  }
}

void FieldConditioning::RequireConsistency(const Eigen::Ref<const Eigen::MatrixXd>& values) const
{
  RequireObserved(values.rows() == this->Deviations.size(),
    std::to_string(values.rows()) + " values; expected " + std::to_string(this->Deviations.size()) + ".");
  RequireObserved(values.allFinite(), "a value is not finite; expected finite numbers.");
  if (this->Dependent.empty())
  {
    return;
  }
  const Eigen::MatrixXd predicted = this->Prediction * RowsOf(values, this->Kept);
  const double scale = values.cwiseAbs().maxCoeff();
  for (std::size_t d = 0; d < this->Dependent.size(); ++d)
  {
    const auto row = static_cast<Eigen::Index>(d);
    const double difference = (predicted.row(row) - values.row(this->Dependent[d])).cwiseAbs().maxCoeff();
    if (!(difference <= ExactAccuracy * scale))
    {
      Eigen::Index other = 0;
      this->Prediction.row(row).cwiseAbs().maxCoeff(&other);
      throw InvalidInput("FieldConditioning: the exact observation " + std::to_string(this->Dependent[d]) +
        " contradicts observation " + std::to_string(this->Kept[static_cast<std::size_t>(other)]) +
        ", from which it follows, by " + FormatNumber(difference) +
        "; expected equal values, or standard deviations above 0.");
    }
  }
}

Eigen::MatrixXd FieldConditioning::SolveSystem(Eigen::MatrixXd rightHandSides) const
{
  this->Root.triangularView<Eigen::Lower>().solveInPlace(rightHandSides);
  this->Root.triangularView<Eigen::Lower>().transpose().solveInPlace(rightHandSides);
  return rightHandSides;
}

Eigen::MatrixXd FieldConditioning::Correct(
  Eigen::MatrixXd fields, const Eigen::Ref<const Eigen::MatrixXd>& values) const
{
  const Eigen::MatrixXd target = RowsOf(values, this->Kept);
  const Eigen::MatrixXd deviations = RowsOf(this->Deviations, this->Kept);
  const SparseRowMatrix transpose = this->Matrix.transpose();
  Eigen::MatrixXd residual = target - this->Matrix * fields;
  const double scale = std::max(residual.cwiseAbs().maxCoeff(), target.cwiseAbs().maxCoeff());
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(target.rows(), target.cols());
  // Iterative refinement of S w = residual with the products themselves, in the space of the fields.
  for (int k = 0; k < MostCorrections; ++k)
  {
    const Eigen::MatrixXd change = this->SolveSystem(residual);
    weights += change;
    fields += this->Covariance(transpose * change);
    residual = target - this->Matrix * fields - deviations.col(0).cwiseAbs2().asDiagonal() * weights;
    if (residual.cwiseAbs().maxCoeff() <= 0.01 * ExactAccuracy * scale)
    {
      return fields;
    }
  }
  if (!(residual.cwiseAbs().maxCoeff() <= ExactAccuracy * scale))
  {
    throw SolverFailure("FieldConditioning: observations are met within " +
      FormatNumber(residual.cwiseAbs().maxCoeff() / scale) +
      " of the largest value; expected 1e-8. Exact observations that lie very close together for the correlation range "
      "make the system ill-conditioned: give them standard deviations.");
  }
  return fields;
}

Eigen::MatrixXd FieldConditioning::Mean(const Eigen::Ref<const Eigen::MatrixXd>& values) const
{
  this->RequireConsistency(values);
  if (this->Kept.empty())
  {
    return Eigen::MatrixXd::Zero(this->Matrix.cols(), values.cols());
  }
  return this->Correct(Eigen::MatrixXd::Zero(this->Matrix.cols(), values.cols()), values);
}

Eigen::MatrixXd FieldConditioning::Sample(const Eigen::Ref<const Eigen::MatrixXd>& prior,
  const Eigen::Ref<const Eigen::MatrixXd>& values, const std::vector<NormalKey>& keys) const
{
  this->RequireConsistency(values);
  RequireObserved(prior.rows() == this->Matrix.cols() && prior.cols() == values.cols() &&
      static_cast<Eigen::Index>(keys.size()) == values.cols(),
    "samples, values and keys have different numbers; expected one column and key for each.");
  if (this->Kept.empty())
  {
    return prior;
  }
  Eigen::MatrixXd noisy = values;
  Eigen::VectorXd errors(values.rows());
  for (std::size_t k = 0; k < keys.size(); ++k)
  {
    NormalKey key = keys[k];
    key.Stream ^= StreamOfErrors;
    FillNormals(key, 0, errors.size(), errors.data());
    noisy.col(static_cast<Eigen::Index>(k)) -= this->Deviations.cwiseProduct(errors);
  }
  return this->Correct(prior, noisy);
}

Eigen::VectorXd FieldConditioning::Variance(const Eigen::VectorXd& priorVariance, const Progress& progress) const
{
  RequireObserved(priorVariance.size() == this->Matrix.cols(),
    std::to_string(priorVariance.size()) + " variances; expected " + std::to_string(this->Matrix.cols()) + ".");
  // C H^T S^-1 H C = X X^T with X = C H^T R^-T for S = R R^T.
  Eigen::VectorXd variance = priorVariance;
  const Eigen::Index count = this->Root.rows();
  const SparseRowMatrix transpose = this->Matrix.transpose();
  for (Eigen::Index first = 0; first < count; first += this->Together)
  {
    const Eigen::Index columns = std::min(this->Together, count - first);
    Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(count, columns);
    chosen.middleRows(first, columns).setIdentity();
    this->Root.triangularView<Eigen::Lower>().transpose().solveInPlace(chosen);
    variance -= this->Covariance(transpose * chosen).rowwise().squaredNorm();
    Report(progress, static_cast<double>(first + columns) / static_cast<double>(count));
  }
  return variance.cwiseMax(0.0);
}

} // namespace surfsynth
