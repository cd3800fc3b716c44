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

/// An indexed triangle mesh. A plain value: no invariant beyond the shapes; CheckMesh() tells what an algorithm may
/// rely on. Vertices that no triangle uses are allowed; they have mass 0.
struct TriangleMesh
{
  PointMatrix Points;       ///< [V, 3]
  TriangleMatrix Triangles; ///< [F, 3], ids in [0, V)

  Index NumberOfPoints() const { return static_cast<Index>(this->Points.rows()); }
  Index NumberOfTriangles() const { return static_cast<Index>(this->Triangles.rows()); }
};

/// Lower and upper corner of the axis-aligned box around the vertices that triangles use; both zero when F = 0.
struct BoundingBox
{
  Eigen::Vector3d Lower = Eigen::Vector3d::Zero();
  Eigen::Vector3d Upper = Eigen::Vector3d::Zero();

  /// Length of the longest side, world units.
  double LongestSide() const { return (this->Upper - this->Lower).maxCoeff(); }
};
BoundingBox ComputeBoundingBox(const TriangleMesh& mesh);

/// 64-bit hash of all coordinates and ids, at memory bandwidth: equal meshes have equal hashes, and two different
/// meshes that a program meets have, for all practical purposes, different ones. The key of caches.
std::uint64_t ContentHash(const TriangleMesh& mesh);

} // namespace surfsynth
