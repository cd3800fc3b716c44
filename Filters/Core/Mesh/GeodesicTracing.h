// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Straight geodesics on a triangle mesh.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleAdjacency.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// End of a geodesic.
struct GeodesicEnd
{
  SurfacePlace Place;        ///< where it ends
  Eigen::Vector3d Direction; ///< unit vector along it there, in the plane of the triangle
  /// False where it ends before its length: at a boundary, at an edge with more than two triangles, or after MostCrossings.
  bool IsComplete = true;
};

/// Traces straight geodesics: straight lines in triangles, which go on straight across edges as if both triangles lay in one
/// plane [Polthier1998]. O(1) for each edge that is crossed. May be called from several threads.
class GeodesicTracer
{
public:
  /// Edges that a geodesic crosses at most: a bound for meshes with needles.
  static constexpr int MostCrossings = 10000;

  /// Computes the normals of the triangles. Keeps references to both.
  /// @param mesh finite, without degenerate triangles, consistently wound
  /// @param adjacency the table of @p mesh
  GeodesicTracer(const TriangleMesh& mesh, const TriangleAdjacency& adjacency);

  /// Unit normal of triangle @p f.
  Eigen::Vector3d Normal(Index f) const { return this->Normals.row(f).transpose(); }

  /// Traces from a place in a triangle.
  /// @param direction unit vector in the plane of the triangle @param length world units, at least 0
  GeodesicEnd Trace(const SurfacePlace& start, const Eigen::Vector3d& direction, double length) const;

private:
  struct Ray;
  int NextSide(const Ray& ray, double& distance) const;
  bool Cross(Ray& ray, int side) const;
  Eigen::Vector3d Weights(const Ray& ray) const;

  const TriangleMesh& Mesh;
  const TriangleAdjacency& Adjacency;
  PointMatrix Normals; ///< [F, 3]
};

} // namespace surfsynth
