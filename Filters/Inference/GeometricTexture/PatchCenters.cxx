// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/PatchCenters.h"

#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterUniforms.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr double Pi = 3.14159265358979323846;

/// Returns the value at a place of numbers at the vertices; 1 without numbers.
double SizeAt(const TriangleMesh& mesh, const SurfacePlace& place, const Eigen::VectorXf& sizes)
{
  double size = sizes.size() > 0 ? 0.0 : 1.0;
  for (int k = 0; k < 3 && sizes.size() > 0; ++k)
  {
    size += place.Weights(k) * static_cast<double>(sizes(mesh.Triangles(place.Triangle, k)));
  }
  return size;
}

/// Returns the areas of the triangles in squares of the spacing, summed up, [F + 1].
std::vector<double> SummedAreas(const PatchSurface& surface, const PatchDistribution& distribution)
{
  const TriangleMesh& mesh = surface.Mesh;
  std::vector<double> sums(static_cast<std::size_t>(mesh.NumberOfTriangles()) + 1, 0.0);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const double size = distribution.Spacing *
      SizeAt(mesh, { f, Eigen::Vector3d::Constant(1.0 / 3.0) }, distribution.Sizes);
    const auto place = static_cast<std::size_t>(f);
    sums[place + 1] = sums[place] + 0.5 * AreaVector(mesh, f).norm() / (size * size);
  }
  return sums;
}

/// Returns the first axis of a grid: along the direction at its center, or at random.
Eigen::Vector3d AxisAt(
  const PatchSurface& surface, const SurfacePlace& place, const PointMatrix* directions, double turn)
{
  const auto corners = surface.Mesh.Triangles.row(place.Triangle);
  const Eigen::Vector3d normal = surface.Tracer.Normal(place.Triangle);
  if (directions)
  {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::Vector3d given = directions->row(corners(k)).transpose();
      const double length = given.norm();
      direction += length > 0.0 ? Eigen::Vector3d(place.Weights(k) / length * given) : Eigen::Vector3d::Zero();
    }
    direction -= direction.dot(normal) * normal;
    if (direction.norm() > 1e-3)
    {
      return direction.normalized();
    }
  }
  const Eigen::Vector3d edge = (surface.Mesh.Points.row(corners(1)) - surface.Mesh.Points.row(corners(0))).normalized();
  const double angle = 2.0 * Pi * turn;
  return (std::cos(angle) * edge + std::sin(angle) * normal.cross(edge)).normalized();
}
} // namespace

double AreaInSquares(const PatchSurface& surface, const PatchDistribution& distribution)
{
  return SummedAreas(surface, distribution).back();
}

std::vector<PatchCenter> DrawPatchCenters(
  const PatchSurface& surface, const PatchDistribution& distribution, std::int64_t count)
{
  const std::vector<double> sums = SummedAreas(surface, distribution);
  std::vector<PatchCenter> centers(static_cast<std::size_t>(count));
  for (std::int64_t p = 0; p < count; ++p)
  {
    const auto uniform = [&](int k) { return Uniform(distribution.Key, 4 * p + k); };
    const double reached = (static_cast<double>(p) + uniform(0)) / static_cast<double>(count) * sums.back();
    const auto next = std::upper_bound(sums.begin() + 1, sums.end() - 1, reached);
    PatchCenter& center = centers[static_cast<std::size_t>(p)];
    const double a = std::sqrt(uniform(1)), b = uniform(2);
    center.Place = { static_cast<Index>(next - sums.begin() - 1), { 1.0 - a, a * (1.0 - b), a * b } };
    center.Spacing = distribution.Spacing * SizeAt(surface.Mesh, center.Place, distribution.Sizes);
    center.XAxis = AxisAt(surface, center.Place, distribution.Directions, uniform(3));
  }
  return centers;
}

} // namespace surfsynth
