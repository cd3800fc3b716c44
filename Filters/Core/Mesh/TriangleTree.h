// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tree of bounding boxes over the triangles of a mesh in groups, for nearest places in or outside of a group, and for
/// intersections with lines. Private to the core.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace surfsynth
{

/// The nearest place found so far.
struct NearestPlace
{
  SurfacePlace Place;                                               ///< none at first
  Eigen::Vector3d Position = Eigen::Vector3d::Zero();               ///< of Place
  double SquaredDistance = std::numeric_limits<double>::infinity(); ///< from the point that is asked for
};

/// The intersection with a line found so far.
struct LineHit
{
  SurfacePlace Place; ///< none at first
  /// Way from the origin of the line to the place, negative against its direction, in lengths of the direction. At first
  /// the largest way, either side, at which an intersection is wanted.
  double Way = std::numeric_limits<double>::infinity();
};

/// Bounding boxes over the triangles of a mesh, halved at the median of centers along the longest side. A box with triangles
/// of one group only is known as such, so that a search outside of a group or in it skips all that it does not want.
class TriangleTree
{
public:
  /// Builds the tree. @p mesh, with at least one triangle, must outlive it.
  /// @param groups of the triangles, [F], numbers from 0
  TriangleTree(const TriangleMesh& mesh, std::vector<Index> groups);

  /// Replaces @p nearest by the place, outside of @p group, that is nearest to @p point, where it is nearer or, at the same
  /// distance, has the smaller coordinates in lexicographic order.
  void FindOutside(Index group, const Eigen::Vector3d& point, NearestPlace& nearest) const;
  /// The same with the places in @p group.
  void FindIn(Index group, const Eigen::Vector3d& point, NearestPlace& nearest) const;
  /// Replaces @p hit by the intersection of a line with a triangle of any group that is nearest to @p origin, where it is
  /// nearer. Only triangles count whose normals, by their winding, have a positive component along @p direction.
  void FindOnLine(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, LineHit& hit) const;

private:
  struct Node
  {
    Eigen::AlignedBox3d Box;
    std::size_t Begin;     ///< first triangle
    std::size_t End;       ///< behind the last
    int Right = -1;        ///< second child; the first follows the node. -1 for a leaf
    Index Group = Several; ///< of all triangles
  };
  static constexpr Index Several = -1;

  int Build(std::size_t begin, std::size_t end);
  template <typename Wanted>
  void Find(int node, const Eigen::Vector3d& point, const Wanted& isWanted, NearestPlace& nearest) const;

  struct Line;
  void FindOnLine(int node, const Line& line, LineHit& hit) const;

  const TriangleMesh& Mesh;
  std::vector<Index> Groups;
  std::vector<Index> Triangles;
  std::vector<Node> Nodes;
};

} // namespace surfsynth
