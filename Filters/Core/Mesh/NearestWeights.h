// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Place in a triangle that is nearest to a point. Private to the core.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>

namespace surfsynth
{

/// Barycentric coordinates of the nearest point of the segment from corner @p i to corner @p j.
inline Eigen::Vector3d NearestOnEdge(
  const std::array<Eigen::Vector3d, 3>& corners, int i, int j, const Eigen::Vector3d& point)
{
  const Eigen::Vector3d edge = corners[j] - corners[i];
  const double length = edge.squaredNorm();
  const double t = length > 0.0 ? std::clamp((point - corners[i]).dot(edge) / length, 0.0, 1.0) : 0.0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  weights[i] = 1.0 - t;
  weights[j] = t;
  return weights;
}

/// Barycentric coordinates of the place in a triangle that is nearest to @p point [Ericson2005]; the triangle may be
/// degenerate.
inline Eigen::Vector3d NearestWeights(const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& point)
{
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  Eigen::Vector3d inside;
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Vector3d edge = corners[(k + 2) % 3] - corners[(k + 1) % 3];
    inside[k] = normal.dot(edge.cross(point - corners[(k + 1) % 3])) / normal.squaredNorm();
  }
  if (inside.allFinite() && inside.minCoeff() >= 0.0)
  {
    return inside / inside.sum();
  }
  // Outside, or without an inside: the nearest point lies on an edge.
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Vector3d weights = NearestOnEdge(corners, k, (k + 1) % 3, point);
    const double distance =
      (weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2] - point).squaredNorm();
    if (distance < nearest)
    {
      nearest = distance;
      best = weights;
    }
  }
  return best;
}

} // namespace surfsynth
