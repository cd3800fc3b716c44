// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Linear finite-element operators on a tetrahedral mesh, in double precision, in O(V + T); the counterparts of
/// SurfaceOperators.h.
///
/// With phi_i the barycentric hat function of vertex i,
///   M_ii = integral of phi_i                        lumped mass, cubic world units
///   L_ij = integral of grad phi_i . H grad phi_j    stiffness, world units; symmetric, x^T L x >= 0, L 1 = 0.
///
/// All functions expect a mesh that passes RequireValidVolume().
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace surfsynth
{

/// Edges of tetrahedron @p t from its first corner to the others, as columns, for @p points at rest or moved, world units.
inline Eigen::Matrix3d EdgesFromFirstCorner(const PointMatrix& points, const TetrahedronMatrix& tetrahedra, Index t)
{
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k)
  {
    edges.col(k) = (points.row(tetrahedra(t, k + 1)) - points.row(tetrahedra(t, 0))).transpose();
  }
  return edges;
}

/// Lumped mass, [V] float64, cubic world units: a quarter of the volume of the tetrahedra around each vertex; 0 for a
/// vertex that no tetrahedron uses. Sums to the volume.
Eigen::VectorXd LumpedMass(const TetrahedralMesh& mesh);

/// Symmetric tensors of the tetrahedra, [T, 6] float64: entries xx, xy, xz, yy, yz, zz in world axes.
using VolumeTensors = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// Diffusion tensors of determinant 1 that stretch along a direction: H = ratio^(4/3) along it and ratio^(-2/3) across,
/// so that lengths are ratio^(2/3) and ratio^(-1/3) times as long; averaged over the corners of each tetrahedron and
/// divided by the cubic root of the determinant.
/// @param directions [V, 3]; signs and lengths do not matter; 0 stands for none (H = 1)
/// @param ratio > 0, no unit
VolumeTensors DirectionTensors(const TetrahedralMesh& mesh, const PointMatrix& directions, double ratio);

/// Stiffness L, [V, V] float64, both triangles stored, columns sorted, every diagonal entry present; rows sum to zero.
/// @param tensors H of each tetrahedron, positive definite, no unit; without rows for H = 1
SparseMatrix VolumeStiffness(const TetrahedralMesh& mesh, const VolumeTensors& tensors = VolumeTensors(0, 6));

/// Lumped mass of the boundary, [V] float64, square world units: a third of the area of the boundary faces at each
/// vertex; 0 inside. Sums to the area of the boundary.
/// @param faces the boundary, FindFaces(mesh).Boundary
/// @param isCounted true for the faces that count; empty for all
Eigen::VectorXd BoundaryMass(const TetrahedralMesh& mesh, const std::vector<FaceVertices>& faces,
  const std::function<bool(const FaceVertices&)>& isCounted = {});

} // namespace surfsynth
