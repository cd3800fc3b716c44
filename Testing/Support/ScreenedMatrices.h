// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Matrices of the screened Poisson equation on surfaces and in volumes, of any size.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/CholeskySolver.h"

#include <cstdint>

namespace surfsynth::test
{

/// A matrix and the masses of its vertices.
struct ScreenedMatrix
{
  SparseMatrix Matrix; ///< L + tau M; 1 on the diagonal of unused points
  Eigen::VectorXd Mass;
};

/// L + tau M of a surface; tau is @p screening over the area.
ScreenedMatrix ScreenedSurface(const TriangleMesh& mesh, double screening = 100.0);

/// L + tau M of linear elements on the unit cube in @p cells^3 cubes of six tetrahedra each [Kuhn1960], whose inner
/// points are moved at random by up to @p jitter cells along each axis; @p stretch multiplies the first coordinate.
ScreenedMatrix ScreenedCube(int cells, double screening = 100.0, double jitter = 0.15, double stretch = 1.0);

/// Unit sphere of 10 * 4^level + 2 vertices, made without tables of edges larger than the mesh.
TriangleMesh LargeSphere(int level);

/// sqrt(M) times numbers in [-1, 1), [V, columns].
RowMatrix NoiseSides(const Eigen::VectorXd& mass, Eigen::Index columns, std::uint64_t seed = 1);

} // namespace surfsynth::test
