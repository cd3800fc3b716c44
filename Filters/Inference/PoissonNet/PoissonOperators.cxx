// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/PoissonOperators.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
constexpr float DiagonalShift = 1e-6F;
constexpr double MassShift = 1e-4;
/// Added to the squared length of cross products in cotangents.
constexpr double SquaredAreaShift = 1e-20;

double SquaredToZero(double value) { return std::sqrt(std::max(value, 0.0)); }

/// One face laid flat by its edge lengths: v0 at the origin, v1 at (l2, 0), v2 at (x, y).
void LayFlat(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1, const Eigen::Vector3d& p2, float* gradient)
{
  const double l0 = (p2 - p1).norm();
  const double l1 = (p0 - p2).norm();
  const double l2 = (p1 - p0).norm();
  const double x = (l1 * l1 + l2 * l2 - l0 * l0) / (2.0 * l2);
  const double y = SquaredToZero(l1 * l1 - x * x);
  const double doubleArea = l2 * y;
  const double values[6] = { -y, y, 0.0, x - l2, -x, l2 };
  std::transform(values, values + 6, gradient, [&](double value) { return static_cast<float>(value / doubleArea); });
}

/// Adds 1e-4 M to the diagonal; vertices without mass, which no equation determines, get that of the others.
void AddMass(SparseMatrix& stiffness, const Eigen::VectorXd& mass)
{
  const double mean = mass.mean();
  for (Index v = 0; v < stiffness.cols(); ++v)
  {
    stiffness.coeffRef(v, v) += MassShift * (mass[v] > 1e-8 * mean ? mass[v] : mean);
  }
}

Eigen::VectorXf RoundedMass(const Eigen::VectorXd& mass) { return (mass.array() + 1e-8 * mass.mean()).cast<float>(); }

void ShiftDiagonal(SparseMatrix& matrix, double shift)
{
  for (Index v = 0; v < matrix.cols(); ++v)
  {
    matrix.coeffRef(v, v) += shift;
  }
}

/// Adds a matrix that may have no rows.
void AddWhereAny(SparseMatrix& matrix, const SparseMatrix& more)
{
  if (more.rows() > 0)
  {
    matrix += more;
  }
}

/// Factors a matrix. When that fails, which slivers can bring about by rounding, adds 1e-5, 1e-4 and so on to the diagonal.
std::shared_ptr<const CholeskySolver> FactorShifted(SparseMatrix matrix, const Progress& progress)
{
  double more = 1e-5;
  for (int attempt = 0;; ++attempt, more *= 10.0)
  {
    try
    {
      return std::make_shared<const CholeskySolver>(matrix, progress);
    }
    catch (const SolverFailure&)
    {
      if (attempt == 5)
      {
        throw;
      }
      ShiftDiagonal(matrix, more);
    }
  }
}
} // namespace

PoissonOperators BuildPoissonOperators(const TriangleMesh& mesh, const MeshTopology& topology, const Progress& progress,
  PoissonShift shift, const ComponentCoupling& coupling)
{
  TriangleMesh rounded = mesh;
  rounded.Points = mesh.Points.cast<float>().cast<double>();

  PoissonOperators operators;
  operators.Triangles = mesh.Triangles;
  operators.Shift = shift;
  operators.Gradient.resize(mesh.NumberOfTriangles(), 6);
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto corner = [&](int k) { return Eigen::Vector3d(rounded.Points.row(mesh.Triangles(f, k)).transpose()); };
      LayFlat(corner(0), corner(1), corner(2), operators.Gradient.row(f).data());
    }
  });
  for (Index f = 0; f < operators.NumberOfTriangles(); ++f)
  {
    if (!operators.Gradient.row(f).allFinite())
    {
      throw InvalidInput("BuildPoissonOperators: triangle " + std::to_string(f) +
        " is degenerate in single precision; expected triangles with an area. Move the mesh to the origin, or merge "
        "close points with vtkCleanPolyData.");
    }
  }
  operators.FaceAreas = FaceAreas(rounded).cast<float>();
  operators.VertexMass = RoundedMass(LumpedMass(rounded, topology));
  Report(progress, 0.1);
  SparseMatrix stiffness = CotangentStiffness(rounded, topology, SquaredAreaShift);
  SparseMatrix coupled = CouplingMatrix(rounded, topology, coupling, SubProgress(progress, 0.1, 0.2));
  const Progress factoring = SubProgress(progress, 0.2, 1.0);
  if (shift == PoissonShift::Mass)
  {
    AddMass(stiffness, LumpedMass(rounded, topology));
    AddWhereAny(stiffness, coupled);
    operators.Solver = FactorShifted(std::move(stiffness), factoring);
  }
  else
  {
    operators.Solver = FactorPoissonMatrix(stiffness, factoring, coupled);
  }
  if (coupled.rows() > 0)
  {
    operators.Coupling = std::make_shared<const SparseMatrix>(std::move(coupled));
  }
  return operators;
}

std::shared_ptr<const CholeskySolver> FactorPoissonMatrix(
  const SparseMatrix& stiffness, const Progress& progress, const SparseMatrix& coupling)
{
  SparseMatrix matrix = stiffness;
  for (Eigen::Index k = 0; k < matrix.nonZeros(); ++k)
  {
    matrix.valuePtr()[k] = static_cast<double>(static_cast<float>(matrix.valuePtr()[k]));
  }
  ShiftDiagonal(matrix, static_cast<double>(DiagonalShift));
  AddWhereAny(matrix, coupling);
  return FactorShifted(std::move(matrix), progress);
}

} // namespace surfsynth
