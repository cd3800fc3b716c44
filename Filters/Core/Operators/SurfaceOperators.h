// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Linear finite-element operators on a triangle mesh: [Kuai2026], appendix F. All are assembled in parallel, in double
/// precision, in O(V + F).
///
/// With phi_i the barycentric hat function of vertex i,
///   M_ii = integral of phi_i                      lumped barycentric mass, square world units
///   L_ij = integral of grad phi_i . grad phi_j    cotangent stiffness, no unit; symmetric, x^T L x >= 0, L 1 = 0
///   G    gradient of a vertex signal in each triangle's own frame, 1 / world units
///   A    face areas;   L = G^T diag(A) G (each area twice, once for each row of G).
///
/// All functions expect a mesh that passes CheckMesh().
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/SparseCore>

#include <functional>

namespace surfsynth
{

/// Sparse float64 matrix, stored by columns.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;
/// Sparse float64 matrix, stored by rows.
using SparseRowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, Index>;

/// Areas of the triangles, [F] float64, square world units.
Eigen::VectorXd FaceAreas(const TriangleMesh& mesh);

/// Lumped barycentric mass, [V] float64, square world units: one third of the area of the triangles around each vertex;
/// 0 for a vertex that no triangle uses. Sums to the surface's area.
/// @param topology the tables of @p mesh
Eigen::VectorXd LumpedMass(const TriangleMesh& mesh, const MeshTopology& topology);
/// Lumped mass of a mesh without tables.
Eigen::VectorXd LumpedMass(const TriangleMesh& mesh);

/// Cotangent stiffness L, [V, V] float64, both triangles stored, columns sorted, every diagonal entry present. Off the
/// diagonal L_ij = -(cot alpha_ij + cot beta_ij) / 2 [Pinkall1993]; rows sum to zero. (Equation 17 of [Kuai2026] prints
/// the same weight without the sign; equation 16 fixes it.)
/// @param topology the tables of @p mesh
/// @param squaredAreaShift added to the square of twice the area in each cotangent, world units to the fourth: bounds
/// the weights of needles. 0, the default, changes nothing.
SparseMatrix CotangentStiffness(const TriangleMesh& mesh, const MeshTopology& topology, double squaredAreaShift = 0.0);
/// Cotangent stiffness of a mesh without tables.
SparseMatrix CotangentStiffness(const TriangleMesh& mesh);

/// Symmetric tensors of the triangles, [F, 3] float64: entries xx, xy, yy in the frame of each face, as of
/// IntrinsicGradient().
using FaceTensors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Stiffness of anisotropic diffusion, L_ij = integral of grad phi_i . H grad phi_j, [V, V] float64, stored as
/// CotangentStiffness(), which it is for H = 1.
/// @param topology the tables of @p mesh
/// @param tensors H of each triangle, positive definite, no unit
SparseMatrix DiffusionStiffness(const TriangleMesh& mesh, const MeshTopology& topology, const FaceTensors& tensors);

/// Diffusion tensors that stretch along a direction: H = ratio along it and 1 / ratio across, of determinant 1, averaged
/// over the corners of each triangle and divided by the root of the determinant.
/// @param directions [V, 3], projected to each triangle's plane; signs and lengths do not matter; 0, or a vector
/// orthogonal to the triangle, stands for none (H = 1)
/// @param ratio > 0, no unit
FaceTensors DirectionTensors(const TriangleMesh& mesh, const PointMatrix& directions, double ratio);

/// Lumped mass of the boundary, [V] float64, world units: half of the length of the boundary edges at each vertex; 0
/// inside. Sums to the length of the boundary.
/// @param topology the tables of @p mesh
/// @param isCounted true for the edges, by their lower and higher vertex, that count; empty for all
Eigen::VectorXd BoundaryMass(
  const TriangleMesh& mesh, const MeshTopology& topology, const std::function<bool(Index, Index)>& isCounted = {});

/// Intrinsic gradient G, [2 F, V] float64: rows 2 f and 2 f + 1 are the two components of the gradient in the frame of
/// face f = (v0, v1, v2), whose x axis is the direction v0 -> v1 and whose y axis points to the side of v2.
SparseRowMatrix IntrinsicGradient(const TriangleMesh& mesh);

/// Tangent frames of the vertices. Rows of vertices that no triangle uses, or whose face normals cancel, hold the
/// world axes.
struct VertexFrames
{
  PointMatrix Normal; ///< [V, 3], unit: area-weighted mean of the face normals
  PointMatrix X;      ///< [V, 3], unit, orthogonal to Normal
  PointMatrix Y;      ///< [V, 3], Normal x X: a tangent vector (a, b) is the complex number a + i b
};
/// Computes the tangent frames of all vertices.
/// @param topology the tables of @p mesh
VertexFrames TangentFrames(const TriangleMesh& mesh, const MeshTopology& topology);

/// Gamma = || M^-1 L ||_F, the Frobenius norm of the discrete Laplace-Beltrami operator ([Kuai2026], section 3.5),
/// 1 / square world units; Gamma^2 is about the sum of the squared eigenvalues. Rows of mass 0 count as zero.
/// @param stiffness L, [V, V]
/// @param mass the diagonal of M, [V]
double LaplaceBeltramiNorm(const SparseMatrix& stiffness, const Eigen::VectorXd& mass);

} // namespace surfsynth
