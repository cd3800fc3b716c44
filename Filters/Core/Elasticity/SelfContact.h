// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Contact of a body with itself: points of the boundary against triangles of the boundary. Private to the library.
#pragma once

#include "Core/Elasticity/Barrier.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <utility>
#include <vector>

namespace surfsynth
{

/// A point of the boundary and the nearest place in a triangle of the boundary.
struct ContactPlace
{
  std::array<Index, 4> Nodes{};              ///< the point, then the corners of the triangle
  double Distance = 0.0;                     ///< meters
  std::array<Eigen::Vector3d, 4> Derivative; ///< of the distance by the positions of the nodes
};

/// A barrier keeps points away from triangles that they do not belong to: no point passes through a triangle. Edges may
/// pass each other, and there is no friction.
class SelfContact
{
public:
  /// A pair (point, triangle).
  using Pair = std::pair<Index, Index>;

  /// Pairs that are nearer than twice the distance of the barrier at rest never touch.
  /// @param areas of the boundary at each node
  SelfContact(const Barrier& barrier, TriangleMatrix boundary, Eigen::VectorXd areas, const PointMatrix& rest);

  /// Finds the pairs that may come nearer than the distance of the barrier in @p move [V, 3], or in a part of it.
  void Find(const PointMatrix& points, const PointMatrix& move);
  /// Pairs of nodes that the pairs found touch each other by.
  std::vector<NodePair> Coupled(const PointMatrix& points) const;

  /// Energy, joules, of the pairs found.
  double Energy(const PointMatrix& points) const;
  /// Adds its derivative to @p gradient.
  void AddGradient(const PointMatrix& points, PointMatrix& gradient) const;
  /// Adds its second derivative, without that of the distance, so that it is positive semi-definite.
  void AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const;
  /// Largest part of a move, at most 1, in which no pair that was found meets.
  double LargestStep(const PointMatrix& points, const PointMatrix& move) const;

private:
  std::vector<Pair> Near(const PointMatrix& points, const PointMatrix& move, double distance) const;
  ContactPlace PlaceOf(const PointMatrix& points, const Pair& pair) const;

  Barrier Surface;
  TriangleMatrix Boundary;
  Eigen::VectorXd Areas;
  std::vector<Index> BoundaryPoints; ///< ascending
  std::vector<Pair> NearAtRest;      ///< ascending
  std::vector<Pair> Pairs;           ///< found
};

} // namespace surfsynth
