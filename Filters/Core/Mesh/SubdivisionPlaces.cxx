// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SubdivisionPlaces.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Number of subdivisions that make @p fine triangles of @p coarse ones; -1 for none.
int LevelsBetween(std::int64_t coarse, std::int64_t fine)
{
  int levels = 0;
  while (coarse > 0 && coarse < fine)
  {
    coarse *= 4;
    ++levels;
  }
  return coarse > 0 && coarse == fine ? levels : -1;
}

/// Reverts SubdivideAtMidpoints(). @return false when the triangles are not those of a subdivision.
bool Coarsen(TriangleMatrix& triangles)
{
  const Eigen::Index count = triangles.rows() / 4;
  TriangleMatrix coarse(count, 3);
  for (Eigen::Index f = 0; f < count; ++f)
  {
    const auto middle = triangles.row(f + 3 * count);
    for (Eigen::Index k = 0; k < 3; ++k)
    {
      const auto child = triangles.row(f + k * count); // corner k, then midpoints k and k - 1
      if (child(1) != middle(k) || child(2) != middle((k + 2) % 3))
      {
        return false;
      }
      coarse(f, k) = child(0);
    }
  }
  triangles = std::move(coarse);
  return true;
}

/// True when each point goes to one point. @param classes, when not empty, of the points that it goes to
bool IsMap(const TriangleMatrix& from, const TriangleMatrix& to, Index points, const std::vector<Index>& classes)
{
  std::vector<Index> image(static_cast<std::size_t>(points), -1);
  for (Eigen::Index k = 0; k < from.size(); ++k)
  {
    Index& known = image[static_cast<std::size_t>(from.data()[k])];
    const Index point = to.data()[k];
    const Index found = classes.empty() ? point : classes[static_cast<std::size_t>(point)];
    if (known != -1 && known != found)
    {
      return false;
    }
    known = found;
  }
  return true;
}
} // namespace

std::optional<SubdivisionPlaces> SubdivisionPlaces::Find(
  const TriangleMesh& mesh, const std::vector<Index>& classes, const TriangleMesh& subdivided)
{
  const int levels = LevelsBetween(mesh.NumberOfTriangles(), subdivided.NumberOfTriangles());
  if (levels < 0)
  {
    return std::nullopt;
  }
  TriangleMatrix triangles = subdivided.Triangles;
  for (int level = 0; level < levels; ++level)
  {
    if (!Coarsen(triangles))
    {
      return std::nullopt;
    }
  }
  const bool isSame = IsMap(mesh.Triangles, triangles, mesh.NumberOfPoints(), {}) &&
    IsMap(triangles, mesh.Triangles, subdivided.NumberOfPoints(), classes);
  return isSame ? std::make_optional(SubdivisionPlaces(mesh.NumberOfTriangles(), levels)) : std::nullopt;
}

SurfacePlace SubdivisionPlaces::OnSubdivision(const SurfacePlace& place) const
{
  SurfacePlace fine = place;
  std::int64_t count = this->Triangles;
  for (int level = 0; level < this->Levels; ++level, count *= 4)
  {
    const Eigen::Vector3d w = fine.Weights;
    Eigen::Index child = 3;
    for (Eigen::Index k = 0; k < 3; ++k)
    {
      child = w[k] >= 0.5 ? k : child;
    }
    fine.Triangle += static_cast<Index>(child * count);
    if (child == 3)
    {
      fine.Weights << w[0] + w[1] - w[2], w[1] + w[2] - w[0], w[2] + w[0] - w[1];
    }
    else
    {
      const double next = w[(child + 1) % 3], last = w[(child + 2) % 3];
      fine.Weights << w[child] - next - last, 2.0 * next, 2.0 * last;
    }
    fine.Weights = fine.Weights.cwiseMax(0.0);
    fine.Weights /= fine.Weights.sum();
  }
  return fine;
}

} // namespace surfsynth
