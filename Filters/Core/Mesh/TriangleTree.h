// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tree of bounding boxes over triangles, for nearest places. Private to the core.
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

/// Bounding boxes over some triangles of a mesh, halved at the median of centers along the longest side.
class TriangleTree
{
public:
  /// Builds the tree. @p mesh must outlive it; @p triangles is not empty.
  TriangleTree(const TriangleMesh& mesh, std::vector<Index> triangles);

  /// Replaces @p nearest by the place of the triangles that is nearest to @p point, where it is nearer or, at the same
  /// distance, has the smaller coordinates in lexicographic order.
  void Find(const Eigen::Vector3d& point, NearestPlace& nearest) const;

private:
  struct Node
  {
    Eigen::AlignedBox3d Box;
    std::size_t Begin; ///< first triangle
    std::size_t End;   ///< behind the last
    int Right = -1;    ///< second child; the first follows the node. -1 for a leaf
  };

  int Build(std::size_t begin, std::size_t end);
  void Find(int node, const Eigen::Vector3d& point, NearestPlace& nearest) const;

  const TriangleMesh& Mesh;
  std::vector<Index> Triangles;
  std::vector<Node> Nodes;
};

} // namespace surfsynth
