// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/WeldedPoints.h"

#include "Core/Mesh/UsedPoints.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
using Bits = std::array<std::uint64_t, 3>;

/// Returns the bits of the coordinates of a point; 0 and -0 are the same.
Bits BitsOf(const TriangleMesh& mesh, Index point)
{
  Bits bits{};
  for (int c = 0; c < 3; ++c)
  {
    const double coordinate = mesh.Points(point, c) + 0.0;
    std::memcpy(&bits[static_cast<std::size_t>(c)], &coordinate, sizeof coordinate);
  }
  return bits;
}
} // namespace

std::vector<Index> WeldPoints(const TriangleMesh& mesh)
{
  std::vector<Index> vertices(static_cast<std::size_t>(mesh.NumberOfPoints()));
  std::iota(vertices.begin(), vertices.end(), 0);
  const UsedPoints used(mesh);
  std::vector<std::pair<Bits, Index>> points(static_cast<std::size_t>(used.Count()));
  for (Index k = 0; k < used.Count(); ++k)
  {
    points[static_cast<std::size_t>(k)] = { BitsOf(mesh, used.Id(k)), used.Id(k) };
  }
  std::sort(points.begin(), points.end());
  for (std::size_t k = 1; k < points.size(); ++k)
  {
    if (points[k].first == points[k - 1].first)
    {
      vertices[static_cast<std::size_t>(points[k].second)] = vertices[static_cast<std::size_t>(points[k - 1].second)];
    }
  }
  return vertices;
}

} // namespace surfsynth
