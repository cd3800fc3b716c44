// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SurfacePlace.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace surfsynth
{

namespace
{
/// Barycentric coordinates of the nearest point of the segment from corner @p i to corner @p j.
Eigen::Vector3d NearestOnEdge(const Eigen::Vector3d corners[3], int i, int j, const Eigen::Vector3d& point)
{
  const Eigen::Vector3d edge = corners[j] - corners[i];
  const double length = edge.squaredNorm();
  const double t = length > 0.0 ? std::clamp((point - corners[i]).dot(edge) / length, 0.0, 1.0) : 0.0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  weights[i] = 1.0 - t;
  weights[j] = t;
  return weights;
}
} // namespace

Eigen::Vector3d PositionOf(const TriangleMesh& mesh, const SurfacePlace& place)
{
  Eigen::RowVector3d position = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    position += place.Weights[k] * mesh.Points.row(mesh.Triangles(place.Triangle, k));
  }
  return position.transpose();
}

SurfacePlace NearestOnTriangle(const TriangleMesh& mesh, Index f, const Eigen::Vector3d& point)
{
  Eigen::Vector3d corners[3];
  for (int k = 0; k < 3; ++k)
  {
    corners[k] = mesh.Points.row(mesh.Triangles(f, k)).transpose();
  }
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  SurfacePlace place{ f };
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Vector3d edge = corners[(k + 2) % 3] - corners[(k + 1) % 3];
    place.Weights[k] = normal.dot(edge.cross(point - corners[(k + 1) % 3])) / normal.squaredNorm();
  }
  if (place.Weights.allFinite() && place.Weights.minCoeff() >= 0.0)
  {
    place.Weights /= place.Weights.sum();
    return place;
  }
  // Outside, or without an inside: the nearest point lies on an edge.
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Vector3d weights = NearestOnEdge(corners, k, (k + 1) % 3, point);
    const double distance =
      (weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2] - point).squaredNorm();
    if (distance < nearest)
    {
      nearest = distance;
      place.Weights = weights;
    }
  }
  return place;
}

} // namespace surfsynth
