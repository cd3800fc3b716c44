// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Nearest neighbours by a k-d tree. Private to the training; no torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// A k-d tree over points, which must outlive it. O(n log n) to build, O(log n) for each query.
class PointTree
{
public:
  /// @param points [N, 3], at least one, finite
  explicit PointTree(const PointMatrix& points);
  ~PointTree();
  PointTree(const PointTree&) = delete;
  PointTree& operator=(const PointTree&) = delete;

  /// The id of the point nearest to each row of @p queries. Parallel.
  std::vector<std::int64_t> Nearest(const PointMatrix& queries) const;
  /// Ids of the @p count points nearest to a query, nearest first; all where there are fewer.
  std::vector<std::uint32_t> Nearest(const Eigen::RowVector3d& query, std::size_t count) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Distances from points to a surface.
struct PointDistances
{
  double Mean = 0.0;
  double Largest = 0.0;
};

/// Distances from each row of @p queries to the triangles of @p surface, exactly. @p queries and the surface are not empty.
/// The same bits for every number of threads.
PointDistances DistanceToSurface(const PointMatrix& queries, const TriangleMesh& surface);

} // namespace surfsynth
