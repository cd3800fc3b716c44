// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Geometry>

#include <cstring>

namespace surfsynth
{

BoundingBox ComputeBoundingBox(const TriangleMesh& mesh)
{
  BoundingBox box;
  if (mesh.NumberOfTriangles() == 0)
  {
    return box;
  }
  box.Lower = box.Upper = mesh.Points.row(mesh.Triangles(0, 0)).transpose();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      const auto point = mesh.Points.row(mesh.Triangles(f, corner)).transpose();
      box.Lower = box.Lower.cwiseMin(point);
      box.Upper = box.Upper.cwiseMax(point);
    }
  }
  return box;
}

Eigen::Vector3d AreaVector(const TriangleMesh& mesh, Index f)
{
  const auto corners = mesh.Triangles.row(f);
  const Eigen::Vector3d p = mesh.Points.row(corners(0)).transpose();
  const Eigen::Vector3d q = mesh.Points.row(corners(1)).transpose();
  const Eigen::Vector3d r = mesh.Points.row(corners(2)).transpose();
  return (q - p).cross(r - p);
}

namespace
{
std::uint64_t Mix(std::uint64_t state, std::uint64_t word)
{
  // Multiply-and-rotate over an odd constant (the golden ratio), one step for each word.
  state = (state ^ word) * 0x9E3779B97F4A7C15ULL;
  return (state << 29) | (state >> 35);
}

/// Four independent chains, so that the multiplications overlap.
std::uint64_t HashBytes(std::uint64_t seed, const void* data, std::size_t size)
{
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t lanes[4] = { seed, seed ^ 0x243F6A8885A308D3ULL, seed ^ 0x13198A2E03707344ULL, seed ^ size };
  std::uint64_t words[4];
  for (; size >= sizeof(words); size -= sizeof(words), bytes += sizeof(words))
  {
    std::memcpy(words, bytes, sizeof(words));
    for (int k = 0; k < 4; ++k)
    {
      lanes[k] = Mix(lanes[k], words[k]);
    }
  }
  std::uint64_t rest[4] = { 0, 0, 0, 0 };
  if (size > 0)
  {
    std::memcpy(rest, bytes, size);
  }
  std::uint64_t hash = seed;
  for (int k = 0; k < 4; ++k)
  {
    hash = Mix(Mix(hash, lanes[k]), rest[k]);
  }
  return hash ^ (hash >> 32);
}
} // namespace

std::uint64_t ContentHash(const TriangleMesh& mesh)
{
  const std::uint64_t points = HashBytes(static_cast<std::uint64_t>(mesh.Points.rows()), mesh.Points.data(),
    sizeof(double) * static_cast<std::size_t>(mesh.Points.size()));
  return HashBytes(points, mesh.Triangles.data(), sizeof(Index) * static_cast<std::size_t>(mesh.Triangles.size()));
}

} // namespace surfsynth
