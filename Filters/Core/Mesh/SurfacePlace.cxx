// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SurfacePlace.h"

#include "Core/Mesh/NearestWeights.h"

#include <array>

namespace surfsynth
{

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
  std::array<Eigen::Vector3d, 3> corners;
  for (int k = 0; k < 3; ++k)
  {
    corners[k] = mesh.Points.row(mesh.Triangles(f, k)).transpose();
  }
  return { f, NearestWeights(corners, point) };
}

} // namespace surfsynth
