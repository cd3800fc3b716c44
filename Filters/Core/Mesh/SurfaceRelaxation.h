// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Relaxation of a mesh along a surface that it lies on.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Search for the nearest places of a surface, and for those of its boundary.
class NearestSurface
{
public:
  /// Builds the search. @p surface, with at least one triangle and finite points, must outlive it. O(F log F).
  explicit NearestSurface(const TriangleMesh& surface);
  ~NearestSurface();
  NearestSurface(const NearestSurface&) = delete;
  NearestSurface& operator=(const NearestSurface&) = delete;

  /// Returns the position on the surface nearest to @p point; nothing where the surface there faces away from @p normal, of
  /// any length: the other side of a thin part.
  std::optional<Eigen::RowVector3d> Nearest(const Eigen::RowVector3d& point, const Eigen::RowVector3d& normal) const;
  /// Returns the place nearest to each row of @p points [N, 3]. Parallel.
  std::vector<SurfacePlace> NearestPlaces(const PointMatrix& points) const;
  /// Returns the position on the boundary nearest to @p point, or @p point on a surface without boundary.
  Eigen::RowVector3d NearestOnBoundary(const Eigen::RowVector3d& point) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Evens the triangles of a mesh along the surface: each round moves each point half of the way to the mean of the centers of
/// its triangles, weighted by their area, or on the boundary of its two neighbors there, and then onto the surface. Parallel,
/// the same bits for every number of threads.
/// @param rounds number of rounds, at least 0
/// @throws Cancelled
void RelaxOnSurface(TriangleMesh& mesh, const MeshTopology& topology, const NearestSurface& surface, int rounds,
  const Progress& progress = {});

/// Smooths a mesh where it folds: the corners of triangles whose normals differ by more than 120 degrees from those of a
/// neighbor, and the points next to them, move half of the way to the mean of their neighbors, again and again until no
/// triangle is folded. Points of a boundary stay. Parallel, the same bits for every number of threads.
/// @param rounds largest number of rounds, at least 0
/// @return number of triangles that are still folded
std::int64_t SmoothFolds(TriangleMesh& mesh, const MeshTopology& topology, int rounds);

} // namespace surfsynth
