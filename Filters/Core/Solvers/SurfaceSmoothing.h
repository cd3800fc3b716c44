// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Implicit smoothing of signals on a surface.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Core>

namespace surfsynth
{

/// The operator S = (1 + l^2 L)^-1, L the Laplace-Beltrami operator: one step of implicit diffusion over the time l^2. Of a wave
/// of wavelength w a share of 1 / (1 + (2 pi l / w)^2) is left. Factored once.
class SurfaceSmoothing
{
public:
  /// Factors the operator.
  /// @param topology the tables of @p mesh @param length l, at least 0, world units
  /// @throws InvalidInput, SolverFailure as CholeskySolver
  SurfaceSmoothing(const TriangleMesh& mesh, const MeshTopology& topology, double length);

  /// Returns S times the rows [V, K]. Rows of points that no triangle uses become 0, and may be anything before.
  RowMatrix Apply(RowMatrix rows) const;

private:
  SurfaceSmoothing(const TriangleMesh& mesh, const MeshTopology& topology, double length, const Eigen::VectorXd& mass);

  Eigen::VectorXd Weights; ///< [V], mass over the area
  CholeskySolver Solver;
};

} // namespace surfsynth
