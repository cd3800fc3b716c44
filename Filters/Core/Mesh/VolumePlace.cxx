// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/VolumePlace.h"

#include "Core/Mesh/SurfacePlace.h"

#include <Eigen/LU>

#include <limits>

namespace surfsynth
{

VolumePlace NearestInTetrahedron(const TetrahedralMesh& mesh, Index t, const Eigen::Vector3d& point)
{
  const auto ids = mesh.Tetrahedra.row(t);
  Eigen::Matrix<double, 3, 4> corners;
  for (int k = 0; k < 4; ++k)
  {
    corners.col(k) = mesh.Points.row(ids(k)).transpose();
  }
  const Eigen::Matrix3d edges = corners.rightCols<3>().colwise() - corners.col(0);
  VolumePlace place{ t, {} };
  place.Weights.tail<3>() = edges.partialPivLu().solve(point - corners.col(0));
  place.Weights[0] = 1.0 - place.Weights.tail<3>().sum();
  if ((place.Weights.array() >= 0.0).all())
  {
    return place;
  }
  TriangleMesh faces{ corners.transpose(), TriangleMatrix(4, 3) };
  faces.Triangles << 1, 2, 3, 0, 2, 3, 0, 1, 3, 0, 1, 2;
  double least = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < 4; ++f)
  {
    const SurfacePlace onFace = NearestOnTriangle(faces, f, point);
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      weights[faces.Triangles(f, k)] = onFace.Weights[k];
    }
    const double distance = (corners * weights - point).squaredNorm();
    if (distance < least)
    {
      least = distance;
      place.Weights = weights;
    }
  }
  return place;
}

Eigen::Vector3d PositionOf(const TetrahedralMesh& mesh, const VolumePlace& place)
{
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4; ++k)
  {
    position += place.Weights[k] * mesh.Points.row(mesh.Tetrahedra(place.Tetrahedron, k)).transpose();
  }
  return position;
}

} // namespace surfsynth
