// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternFieldInternals.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
bool IsPositive(double value) { return value > 0.0 && std::isfinite(value); }

bool IsAtLeastZero(double value) { return value == 0.0 || IsPositive(value); }

/// Requirements on what the models with tau have in common.
void RequireScale(const MaternFieldOptions& options, int dimension)
{
  RequireOption(options.OperatorPower >= 1.0 && options.OperatorPower <= 4.0, "the operator power alpha",
    options.OperatorPower, "a number from 1 to 4");
  switch (options.Mode)
  {
    case ScaleMode::CorrelationRange:
      RequireOption(IsAtLeastZero(options.CorrelationRange), "the correlation range", options.CorrelationRange,
        "a finite number, at least 0 (0: 0.2 times the longest side)");
      RequireOption(options.OperatorPower > 0.5 * dimension, "the operator power alpha", options.OperatorPower,
        dimension == 2 ? "more than 1 with a correlation range: on a surface alpha = 1 has the smoothness nu = 0, no "
                         "finite variance and no range; give the screening term tau instead"
                       : "more than 1.5 with a correlation range: in a volume alpha = 1 has the smoothness nu = -1/2, "
                         "no finite variance and no range; give the screening term tau instead");
      break;
    case ScaleMode::Screening:
      RequireOption(
        IsPositive(options.Screening), "the screening term tau", options.Screening, "a finite number above 0");
      break;
    case ScaleMode::NormalizedScreening:
      RequireOption(IsPositive(options.NormalizedScreening), "the normalised screening c", options.NormalizedScreening,
        "a finite number above 0");
      break;
  }
}

/// Requires an array of one entry for each point or triangle, or none.
void RequireSize(const char* name, Eigen::Index size, Eigen::Index expected, const char* of)
{
  if (size != 0 && size != expected)
  {
    throw InvalidInput(std::string("MaternField: there are ") + std::to_string(size) + " " + name + "; expected " +
      std::to_string(expected) + ", one for each " + of + ".");
  }
}
} // namespace

bool MaternFieldArrays::operator==(const MaternFieldArrays& other) const
{
  const auto same = [](const auto& a, const auto& b) { return a.size() == b.size() && (a.array() == b.array()).all(); };
  return same(this->RangeFactors, other.RangeFactors) && same(this->Directions, other.Directions) &&
    this->BoundaryMask == other.BoundaryMask && this->Barrier == other.Barrier;
}

bool HasTau(NoiseModel model) { return model == NoiseModel::Matern || model == NoiseModel::Spectral; }

void RequireOption(bool condition, const char* name, double value, const char* expected)
{
  if (!condition)
  {
    throw InvalidInput(
      std::string("MaternField: ") + name + " is " + FormatNumber(value) + "; expected " + expected + ".");
  }
}

void RequireOptions(const MaternFieldOptions& options, int dimension)
{
  const bool isMatern = options.Model == NoiseModel::Matern;
  const bool hasDeviation = options.Model == NoiseModel::PerVertex || (isMatern && options.VarianceCorrection) ||
    (HasTau(options.Model) && options.Mode == ScaleMode::CorrelationRange);
  if (HasTau(options.Model))
  {
    RequireScale(options, dimension);
  }
  if (hasDeviation)
  {
    RequireOption(IsAtLeastZero(options.StandardDeviation), "the standard deviation", options.StandardDeviation,
      "a finite number, at least 0");
  }
  if (isMatern && options.CoherentNoise)
  {
    RequireOption(std::fmod(options.OperatorPower, 2.0) != 1.0, "the operator power of coherent noise",
      options.OperatorPower, "another than 1 and 3, whose right-hand sides are not white noise");
  }
  if (isMatern && options.Boundary == BoundaryCondition::Robin)
  {
    RequireOption(IsAtLeastZero(options.RobinCoefficient), "the coefficient of the Robin condition",
      options.RobinCoefficient, "a finite number, at least 0");
  }
  if (isMatern && options.Arrays.Directions.size() > 0)
  {
    RequireOption(
      IsPositive(options.AnisotropyRatio), "the anisotropy ratio", options.AnisotropyRatio, "a finite number above 0");
  }
}

void RequireArrays(const MaternFieldOptions& options, Eigen::Index points, Eigen::Index cells)
{
  if (options.Model != NoiseModel::Matern)
  {
    return;
  }
  const MaternFieldArrays& arrays = options.Arrays;
  RequireSize("range factors", arrays.RangeFactors.size(), points, "point");
  RequireSize("directions", arrays.Directions.rows(), points, "point");
  RequireSize("entries in the boundary mask", static_cast<Eigen::Index>(arrays.BoundaryMask.size()), points, "point");
  RequireSize("entries in the barrier", static_cast<Eigen::Index>(arrays.Barrier.size()), cells, "cell");
  for (Eigen::Index v = 0; v < arrays.RangeFactors.size(); ++v)
  {
    if (!IsPositive(arrays.RangeFactors[v]))
    {
      throw InvalidInput("MaternField: the range factor of point " + std::to_string(v) + " is " +
        FormatNumber(arrays.RangeFactors[v]) + "; expected a finite number above 0.");
    }
  }
  for (Eigen::Index v = 0; v < arrays.Directions.rows(); ++v)
  {
    if (!arrays.Directions.row(v).allFinite())
    {
      throw InvalidInput(
        "MaternField: the direction of point " + std::to_string(v) + " is not finite; expected finite numbers.");
    }
  }
}

bool IsAnisotropic(const MaternFieldOptions& options)
{
  return options.Model == NoiseModel::Matern && options.Arrays.Directions.rows() > 0 && options.AnisotropyRatio != 1.0;
}

double RangeFactorOfEdge(const MaternFieldOptions& options, Index a, Index b)
{
  const Eigen::VectorXd& factors = options.Arrays.RangeFactors;
  return options.Model == NoiseModel::Matern && factors.size() > 0 ? std::min(factors[a], factors[b]) : 1.0;
}

SparseMatrix FieldStiffness(const TriangleMesh& mesh, const MeshTopology& topology, const MaternFieldOptions& options)
{
  return IsAnisotropic(options)
    ? DiffusionStiffness(mesh, topology, DirectionTensors(mesh, options.Arrays.Directions, options.AnisotropyRatio))
    : CotangentStiffness(mesh, topology);
}

std::vector<bool> PinnedVertices(const MeshTopology& topology, const MaternFieldOptions& options)
{
  std::vector<bool> pinned;
  if (options.Boundary != BoundaryCondition::Dirichlet || !options.Arrays.BoundaryMask.empty())
  {
    return options.Boundary == BoundaryCondition::Dirichlet ? options.Arrays.BoundaryMask : pinned;
  }
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    pinned.push_back(topology.IsOnBoundary(v));
  }
  return pinned;
}

Eigen::VectorXd RobinMass(const TriangleMesh& mesh, const MeshTopology& topology, const MaternFieldOptions& options)
{
  if (options.Boundary != BoundaryCondition::Robin)
  {
    return {};
  }
  const std::vector<bool>& mask = options.Arrays.BoundaryMask;
  std::function<bool(Index, Index)> isMasked;
  if (!mask.empty())
  {
    isMasked = [&mask](Index a, Index b) { return mask[a] && mask[b]; };
  }
  return options.RobinCoefficient * BoundaryMass(mesh, topology, isMasked);
}

double LongestEdgeForRange(const TriangleMesh& mesh, const MaternFieldOptions& options)
{
  const MaternFieldArrays& arrays = options.Arrays;
  const bool isMatern = options.Model == NoiseModel::Matern;
  const bool isAnisotropic = IsAnisotropic(options);
  const FaceTensors tensors = isAnisotropic ? DirectionTensors(mesh, arrays.Directions, options.AnisotropyRatio)
                                            : FaceTensors();
  double longest = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (isMatern && !arrays.Barrier.empty() && arrays.Barrier[f])
    {
      continue;
    }
    const auto t = mesh.Triangles.row(f);
    const Eigen::RowVector3d x = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).normalized();
    for (int k = 0; k < 3; ++k)
    {
      const Index a = t(k);
      const Index b = t((k + 1) % 3);
      const Eigen::RowVector3d edge = mesh.Points.row(b) - mesh.Points.row(a);
      double squared = edge.squaredNorm();
      if (isAnisotropic)
      {
        // e^T H^-1 e for tensors H = [[p, q], [q, r]] of determinant 1; signs of the second axis follow the triangle.
        const double along = edge.dot(x);
        const double side = k == 0 ? 0.0 : k == 1 ? 1.0 : -1.0;
        const double across = side * std::sqrt(std::max(squared - along * along, 0.0));
        squared = tensors(f, 2) * along * along - 2.0 * tensors(f, 1) * along * across +
          tensors(f, 0) * across * across;
      }
      longest = std::max(longest, std::sqrt(std::max(squared, 0.0)) / RangeFactorOfEdge(options, a, b));
    }
  }
  return longest;
}

TriangleMesh WithoutTriangles(const TriangleMesh& mesh, const std::vector<bool>& removed)
{
  TriangleMesh rest{ mesh.Points, TriangleMatrix(mesh.Triangles.rows(), 3) };
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    if (!removed[f])
    {
      rest.Triangles.row(count++) = mesh.Triangles.row(f);
    }
  }
  rest.Triangles.conservativeResize(count, 3);
  return rest;
}

void DecoupleRows(SparseMatrix& matrix, const Eigen::VectorXd& mass)
{
  for (Index column = 0; column < matrix.cols(); ++column)
  {
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry)
    {
      if (!(mass[column] > 0.0 && mass[entry.row()] > 0.0))
      {
        entry.valueRef() = 0.0;
      }
    }
  }
}

void AddToDiagonal(SparseMatrix& matrix, const Eigen::VectorXd& diagonal)
{
  for (Index v = 0; v < matrix.cols(); ++v)
  {
    const Index* first = matrix.innerIndexPtr() + matrix.outerIndexPtr()[v];
    const Index* last = matrix.innerIndexPtr() + matrix.outerIndexPtr()[v + 1];
    matrix.valuePtr()[std::lower_bound(first, last, v) - matrix.innerIndexPtr()] += diagonal[v];
  }
}

} // namespace surfsynth
