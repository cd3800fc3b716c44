// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Operators of a mesh for networks in the gradient domain [Maesumi2025]. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/ComponentCoupling.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Core>

#include <memory>

namespace surfsynth
{

/// Basis gradients: gradients of the three barycentric hat functions of each face, [F, 6] float32, 1 / world units: x
/// components of corners 0, 1, 2, then their y components. The x axis of a face is its edge v0 -> v1, the y axis points
/// to the side of v2.
using FaceGradients = Eigen::Matrix<float, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// Shift that makes the matrix of the Poisson equation regular.
enum class PoissonShift
{
  /// 1e-6 I, as published: it acts as a screening that grows with the number of vertices. On a sphere 1.3 million faces lose
  /// 2.5 % of the first mode.
  Identity,
  /// 1e-4 M, M the mass matrix: mode k keeps lambda_k / (lambda_k + 1e-4) on every triangulation.
  Mass
};

/// The operators of one mesh: gradient G, face areas A (each stands for two rows of G), vertex mass m, and the
/// factorised matrix of the Poisson equation, L plus a shift.
///
/// They follow the published PoissonNet: vertices are rounded to float32, operators are computed from those in double
/// and rounded to float32, the matrix is double(float32(L)) + double(float32(1e-6)) I and is factorised in double; with
/// PoissonShift::Mass it is L + 1e-4 M in double. Shifts are absolute, so meshes should have about unit area. Cheap to copy.
struct PoissonOperators
{
  TriangleMatrix Triangles;   ///< [F, 3]
  FaceGradients Gradient;     ///< [F, 6]
  Eigen::VectorXf FaceAreas;  ///< [F]
  Eigen::VectorXf VertexMass; ///< [V], a third of the area around, plus 1e-8 of the mean so that none is zero
  std::shared_ptr<const CholeskySolver> Solver; ///< factor of the matrix of the Poisson equation
  PoissonShift Shift = PoissonShift::Identity;  ///< in that matrix
  /// w B'B, [V, V], which the matrix contains where components are coupled; null for none.
  std::shared_ptr<const SparseMatrix> Coupling;

  /// Number of vertices, V.
  Index NumberOfPoints() const { return static_cast<Index>(this->VertexMass.size()); }
  /// Number of faces, F.
  Index NumberOfTriangles() const { return static_cast<Index>(this->Triangles.rows()); }
};

/// Builds the operators of @p mesh, whose tables are @p topology.
/// @param coupling of the components, its distance in the units of @p mesh; changes no bit for one component
/// @throws InvalidInput when a triangle is degenerate once its vertices are rounded to float32, and as
/// CouplingMatrix().
/// @throws SolverFailure as FactorPoissonMatrix(), with either shift; Cancelled.
PoissonOperators BuildPoissonOperators(const TriangleMesh& mesh, const MeshTopology& topology,
  const Progress& progress = {}, PoissonShift shift = PoissonShift::Identity, const ComponentCoupling& coupling = {});

/// Factors double(float32(@p stiffness)) + double(float32(1e-6)) I, plus @p coupling where it has rows. When that
/// fails, adds 1e-5, then 1e-4 and so on to the diagonal, each on top of the last, up to five times.
/// @throws SolverFailure when even that fails; Cancelled.
std::shared_ptr<const CholeskySolver> FactorPoissonMatrix(
  const SparseMatrix& stiffness, const Progress& progress = {}, const SparseMatrix& coupling = {});

} // namespace surfsynth
