// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The triangle mesh that every algorithm of the library works on.
#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Vertex and face ids. 32 bits: meshes of up to 2^31 - 1 vertices.
using Index = std::int32_t;

/// Vertex positions, [V, 3] float64, in the caller's world units.
using PointMatrix = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Vertex ids of the corners of each triangle, [F, 3] int32, wound as the caller wound them.
using TriangleMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// An indexed triangle mesh. A plain value without invariants beyond the shapes; CheckMesh() finds its defects.
/// Vertices that no triangle uses are allowed; they have mass 0.
struct TriangleMesh
{
  PointMatrix Points;       ///< [V, 3]
  TriangleMatrix Triangles; ///< [F, 3], ids in [0, V)

  /// Number of vertices, V, used or not.
  Index NumberOfPoints() const { return static_cast<Index>(this->Points.rows()); }
  /// Number of triangles, F.
  Index NumberOfTriangles() const { return static_cast<Index>(this->Triangles.rows()); }
};

/// An axis-aligned box, world units.
struct BoundingBox
{
  Eigen::Vector3d Lower = Eigen::Vector3d::Zero(); ///< smallest coordinates
  Eigen::Vector3d Upper = Eigen::Vector3d::Zero(); ///< largest coordinates

  /// Length of the longest side, world units.
  double LongestSide() const { return (this->Upper - this->Lower).maxCoeff(); }
};
/// Box around the vertices that triangles use; both corners are zero when F = 0.
BoundingBox ComputeBoundingBox(const TriangleMesh& mesh);

/// Twice the area times the unit normal of triangle @p f, square world units.
Eigen::Vector3d AreaVector(const TriangleMesh& mesh, Index f);

/// 64-bit hash of all coordinates and ids, at memory bandwidth; the key of caches. Equal meshes have equal hashes;
/// different meshes have, for all practical purposes, different ones.
std::uint64_t ContentHash(const TriangleMesh& mesh);

} // namespace surfsynth
