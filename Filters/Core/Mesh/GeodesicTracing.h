// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Straight geodesics on a triangle mesh.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleAdjacency.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// End of a geodesic.
struct GeodesicEnd
{
  SurfacePlace Place;        ///< where it ends
  Eigen::Vector3d Direction; ///< unit vector along it there, in the plane of the triangle
  /// False where it ends before its length: at a boundary, at an edge with more than two triangles or
  /// inconsistent winding, or after MostCrossings.
  bool IsComplete = true;
};

/// Traces straight geodesics: straight lines in triangles, which go on straight across edges as if both triangles lay in one
/// plane [Polthier1998]. O(1) for each edge that is crossed. May be called from several threads.
class GeodesicTracer
{
public:
  /// Edges that a geodesic crosses at most: a bound for meshes with needles.
  static constexpr int MostCrossings = 10000;

  /// Lays each triangle into a plane. Keeps a reference to the mesh.
  /// @param mesh finite, without degenerate triangles, consistently wound
  /// @param adjacency the table of @p mesh
  GeodesicTracer(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

  /// Unit normal of triangle @p f.
  Eigen::Vector3d Normal(Index f) const { return this->Normals.row(f).transpose(); }

  /// Traces from a place in a triangle.
  /// @param direction unit vector in the plane of the triangle @param length world units, at least 0
  GeodesicEnd Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, double length) const;

  /// Traces @p count geodesics in the same direction, in the time of the longest.
  /// @param lengths ascending @param[out] ends of each
  void Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, int count, const double* lengths,
    GeodesicEnd* ends) const;

private:
  struct Ray;

  /// A triangle in a plane: corner 0 in the origin, corner 1 on the x axis, the others counterclockwise.
  struct Layout
  {
    std::array<Eigen::Vector2d, 3> Corners;
    std::array<Eigen::Vector2d, 3> Edges; ///< unit vectors along the sides
    std::array<Index, 3> Across;          ///< triangle beyond each side; below 0 for none
    std::array<std::int8_t, 3> Sides;     ///< number of the side there
  };

  const Layout& LayoutOf(Index f) const { return this->Layouts[static_cast<std::size_t>(f)]; }
  /// Axes of the plane of a triangle, as columns.
  Eigen::Matrix<double, 3, 2> Axes(Index f) const;
  void LayOut(Index f, const TriangleAdjacency& adjacency);
  int NextSide(const Ray& ray, double& distance) const;
  bool Cross(Ray& ray, int side) const;
  GeodesicEnd EndOf(const Ray& ray, bool isComplete) const;

  const TriangleMesh& Mesh;
  PointMatrix Normals; ///< [F, 3]
  std::vector<Layout> Layouts;
};

} // namespace surfsynth
