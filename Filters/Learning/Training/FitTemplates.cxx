// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FitTemplates.h"

#include "Core/Mesh/MidpointSubdivision.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

TriangleMesh MakeIcosphere(std::int64_t level)
{
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleMesh mesh;
  mesh.Points.resize(12, 3);
  // Corners of three rectangles that stand on each other.
  mesh.Points << -1, golden, 0, 1, golden, 0, -1, -golden, 0, 1, -golden, 0, 0, -1, golden, 0, 1, golden, 0, -1,
    -golden, 0, 1, -golden, golden, 0, -1, golden, 0, 1, -golden, 0, -1, -golden, 0, 1;
  mesh.Triangles.resize(20, 3);
  mesh.Triangles << 0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,
    9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6, 7, 9, 8, 1;
  mesh.Points.rowwise().normalize();
  for (std::int64_t k = 0; k < level; ++k)
  {
    mesh = SubdivideAtMidpoints(mesh).Mesh;
    mesh.Points.rowwise().normalize();
  }
  return mesh;
}

TriangleMesh MakeTorus(std::int64_t segments)
{
  constexpr double tube = 0.4;
  const double turn = 2.0 * std::acos(-1.0);
  const auto along = static_cast<Index>(segments);
  const Index around = std::max<Index>(3, along / 3);
  TriangleMesh mesh;
  mesh.Points.resize(along * around, 3);
  mesh.Triangles.resize(2 * along * around, 3);
  for (Index i = 0; i < along; ++i)
  {
    for (Index j = 0; j < around; ++j)
    {
      const double longitude = turn * i / along;
      const double angle = turn * j / around;
      const double radius = 1.0 + tube * std::cos(angle);
      const Index corner = i * around + j;
      mesh.Points.row(corner) << radius * std::cos(longitude), radius * std::sin(longitude), tube * std::sin(angle);
      const Index right = (i + 1) % along * around + j;
      const Index up = i * around + (j + 1) % around;
      const Index beyond = (i + 1) % along * around + (j + 1) % around;
      mesh.Triangles.row(2 * corner) << corner, right, beyond;
      mesh.Triangles.row(2 * corner + 1) << corner, beyond, up;
    }
  }
  return mesh;
}

} // namespace surfsynth
