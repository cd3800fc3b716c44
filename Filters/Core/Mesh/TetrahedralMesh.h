// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tetrahedral meshes of volumes: their check, boundary and components.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Vertex ids of the corners of each tetrahedron, [T, 4] int32.
using TetrahedronMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 4, Eigen::RowMajor>;

/// An indexed tetrahedral mesh. A plain value without invariants beyond the shapes; RequireValidVolume() finds its
/// defects. Vertices that no tetrahedron uses are allowed; they have mass 0.
struct TetrahedralMesh
{
  PointMatrix Points;           ///< [V, 3], world units
  TetrahedronMatrix Tetrahedra; ///< [T, 4], ids in [0, V)

  /// Number of vertices, V, used or not.
  Index NumberOfPoints() const { return static_cast<Index>(this->Points.rows()); }
  /// Number of tetrahedra, T.
  Index NumberOfTetrahedra() const { return static_cast<Index>(this->Tetrahedra.rows()); }
};

/// Box around the vertices that tetrahedra use; both corners are zero when T = 0.
BoundingBox ComputeBoundingBox(const TetrahedralMesh& mesh);

/// 64-bit hash of all coordinates and ids; see ContentHash() of triangle meshes.
std::uint64_t ContentHash(const TetrahedralMesh& mesh);

/// Length of the longest edge, world units.
double FindLongestEdge(const TetrahedralMesh& mesh);

/// Six times the signed volume of tetrahedron @p t, cubic world units: above 0 where corners 1, 2, 3 run
/// counterclockwise seen from corner 0's other side, as VTK orders them.
double SixfoldVolume(const TetrahedralMesh& mesh, Index t);

/// Vertex ids of a triangle, ascending.
using FaceVertices = std::array<Index, 3>;

/// Faces of a tetrahedral mesh.
struct TetrahedronFaces
{
  std::vector<FaceVertices> Boundary; ///< faces of one tetrahedron, ascending
  std::int64_t NumberOfShared = 0;    ///< faces of three or more tetrahedra
  FaceVertices FirstShared{};         ///< the first of them
};
/// Finds the faces, in O(V + T), without memory of faces inside.
TetrahedronFaces FindFaces(const TetrahedralMesh& mesh);

/// Finds the connected components: tetrahedra that share a vertex. Area holds the volume of each, cubic world units;
/// EulerCharacteristic is 0 and Closed false.
/// @param mass [V], the lumped mass
MeshComponents ComputeComponents(const TetrahedralMesh& mesh, const Eigen::VectorXd& mass);

/// Returns @p mesh without the tetrahedra that @p removed, [T], marks; all points stay.
TetrahedralMesh WithoutTetrahedra(const TetrahedralMesh& mesh, const std::vector<bool>& removed);

/// Checks a mesh, and counts the tetrahedra of negative volume, which are no error: operators and places do not depend
/// on the orientation.
/// @param cellOfTetrahedron turns ids of tetrahedra into the caller's cell ids, for messages; empty when they are the
/// same
/// @return number of inverted tetrahedra, of negative volume
/// @throws InvalidInput, naming the defect, how many, the first id and a repair, when there is no tetrahedron, an id is
/// out of range, a used point is not finite, a tetrahedron uses a point twice, its volume is 0 (below 1e-12 of its
/// longest edge cubed, sixfold), or three or more tetrahedra share a face.
std::int64_t RequireValidVolume(
  const TetrahedralMesh& mesh, const std::function<std::int64_t(std::int64_t)>& cellOfTetrahedron = {});

} // namespace surfsynth
