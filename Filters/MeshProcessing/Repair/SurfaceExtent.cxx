// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/SurfaceExtent.h"

#include "Core/Mesh/MeshStatistics.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <vector>

namespace surfsynth
{

SurfaceExtent MeasureExtent(const TriangleMesh& mesh, bool isClosed)
{
  SurfaceExtent extent;
  extent.Area = SurfaceArea(mesh);
  extent.IsClosed = isClosed && mesh.NumberOfTriangles() > 0;
  std::vector<Index> root(static_cast<std::size_t>(mesh.NumberOfPoints()));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](Index v) {
    while (root[v] != v)
    {
      v = root[v] = root[root[v]];
    }
    return v;
  };
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    root[find(mesh.Triangles(f, 1))] = find(mesh.Triangles(f, 0));
    root[find(mesh.Triangles(f, 2))] = find(mesh.Triangles(f, 0));
  }
  const Eigen::RowVector3d origin = mesh.NumberOfPoints() > 0 ? Eigen::RowVector3d(mesh.Points.row(0))
                                                              : Eigen::RowVector3d::Zero();
  std::vector<double> volume(root.size(), 0.0);
  std::vector<bool> isUsed(root.size(), false);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d a = (mesh.Points.row(t(0)) - origin).transpose();
    const Eigen::Vector3d b = (mesh.Points.row(t(1)) - origin).transpose();
    const Eigen::Vector3d c = (mesh.Points.row(t(2)) - origin).transpose();
    const Index component = find(t(0));
    volume[component] += a.dot(b.cross(c)) / 6.0;
    isUsed[component] = true;
  }
  extent.Components = std::count(isUsed.begin(), isUsed.end(), true);
  if (extent.IsClosed)
  {
    extent.Volume = std::accumulate(
      volume.begin(), volume.end(), 0.0, [](double sum, double part) { return sum + std::abs(part); });
  }
  return extent;
}

double LostFraction(double before, double after)
{
  return before > 0.0 ? std::max((before - after) / before, 0.0) : 0.0;
}

double LargestLoss(const SurfaceExtent& before, const SurfaceExtent& after)
{
  const double volume = before.IsClosed && after.IsClosed ? LostFraction(before.Volume, after.Volume) : 0.0;
  const double components = before.Components > 0
    ? static_cast<double>(std::abs(after.Components - before.Components)) / static_cast<double>(before.Components)
    : 0.0;
  return std::max({ LostFraction(before.Area, after.Area), volume, components });
}

} // namespace surfsynth
