// SPDX-License-Identifier: BSD-3-Clause
// Gains of the lowest modes of spheres when their gradients are integrated.
#pragma once

#include "Core/Operators/SurfaceOperators.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <cmath>

namespace surfsynth::test
{

/// The nine harmonic polynomials of degree 1 and 2 at points of a sphere, and one of degree 3: [V, 10].
inline Eigen::MatrixXd LowestModes(const PointMatrix& points)
{
  const Eigen::ArrayXd x = points.col(0).array();
  const Eigen::ArrayXd y = points.col(1).array();
  const Eigen::ArrayXd z = points.col(2).array();
  Eigen::MatrixXd modes(points.rows(), 10);
  modes << x, y, z, x * y, y * z, z * x, x * x - y * y, 2 * z * z - x * x - y * y, x * y * z, x * (x * x - 3 * y * y);
  return modes;
}

/// Gains of the lowest modes on a sphere of unit area: of a mode f, <f, A^-1 L f> / <f, f> with L the stiffness.
inline Eigen::VectorXd Responses(const TriangleMesh& sphere, PoissonShift shift)
{
  TriangleMesh mesh = sphere;
  const MeshTopology topology(mesh);
  mesh.Points *= 1.0 / std::sqrt(FaceAreas(mesh).sum());
  const PoissonOperators operators = BuildPoissonOperators(mesh, topology, {}, shift);
  const Eigen::VectorXd mass = operators.VertexMass.cast<double>();
  Eigen::MatrixXd modes = LowestModes(sphere.Points);
  modes.rowwise() -= (mass.transpose() * modes / mass.sum()).eval();
  const SparseMatrix stiffness = CotangentStiffness(mesh, topology);
  Eigen::VectorXd gains(modes.cols());
  for (Eigen::Index k = 0; k < modes.cols(); ++k)
  {
    const Eigen::VectorXd mode = modes.col(k);
    Eigen::VectorXd solved = operators.Solver->Solve(stiffness * mode);
    solved.array() -= mass.dot(solved) / mass.sum();
    gains[k] = (mass.array() * mode.array() * solved.array()).sum() / (mass.array() * mode.array().square()).sum();
  }
  return gains;
}

inline double LargestDifference(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  return (a - b).cwiseAbs().maxCoeff();
}

} // namespace surfsynth::test
