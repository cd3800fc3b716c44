// SPDX-License-Identifier: BSD-3-Clause
#include "MeshChecks.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"

#include <Eigen/LU>

#include <algorithm>
#include <limits>

namespace surfsynth::test
{

std::string DefectsOf(const TriangleMesh& mesh, bool closed)
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = requirements.ConsistentWinding = true;
  requirements.Closed = closed;
  return DescribeFindings(CheckMesh(mesh, requirements));
}

double VolumeOf(const TriangleMesh& mesh)
{
  double sum = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
    {
      corners.col(k) = mesh.Points.row(mesh.Triangles(f, k)).transpose();
    }
    sum += corners.determinant() / 6.0;
  }
  return sum;
}

double AreaOf(const TriangleMesh& mesh) { return ComputeMeshStatistics(mesh).Area; }

std::int64_t EulerCharacteristicOf(const TriangleMesh& mesh)
{
  return ComputeMeshStatistics(mesh).EulerCharacteristic();
}

std::vector<SurfacePlace> NearestPlaces(const TriangleMesh& mesh, const PointMatrix& points)
{
  std::vector<SurfacePlace> places(static_cast<std::size_t>(points.rows()));
  ParallelFor(points.rows(), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p)
    {
      const Eigen::Vector3d point = points.row(p).transpose();
      double nearest = std::numeric_limits<double>::infinity();
      for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
      {
        const SurfacePlace place = NearestOnTriangle(mesh, f, point);
        const double distance = (PositionOf(mesh, place) - points.row(p).transpose()).squaredNorm();
        if (distance < nearest)
        {
          nearest = distance;
          places[static_cast<std::size_t>(p)] = place;
        }
      }
    }
  });
  return places;
}

double LargestDistance(const PointMatrix& points, const TriangleMesh& mesh)
{
  const std::vector<SurfacePlace> places = NearestPlaces(mesh, points);
  double largest = 0.0;
  for (std::size_t p = 0; p < places.size(); ++p)
  {
    const double distance = (PositionOf(mesh, places[p]) - points.row(static_cast<Eigen::Index>(p)).transpose()).norm();
    largest = std::max(largest, distance);
  }
  return largest;
}

bool SameTriangles(const TriangleMatrix& a, const TriangleMatrix& b)
{
  if (a.rows() != b.rows())
  {
    return false;
  }
  for (Eigen::Index f = 0; f < a.rows(); ++f)
  {
    bool same = false;
    for (int turn = 0; turn < 3; ++turn)
    {
      same = same || (a(f, 0) == b(f, turn) && a(f, 1) == b(f, (turn + 1) % 3) && a(f, 2) == b(f, (turn + 2) % 3));
    }
    if (!same)
    {
      return false;
    }
  }
  return true;
}

} // namespace surfsynth::test
