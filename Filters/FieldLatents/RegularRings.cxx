// SPDX-License-Identifier: BSD-3-Clause
#include "RegularRings.h"

#include "SurfaceArrays.h"
#include "WeldedSurface.h"

#include "Core/Random/CounterUniforms.h"
#include "Core/Tangent/TangentHierarchy.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>

namespace surfsynth
{

namespace
{
/// Rounds of moves. One is enough unless moves of neighbors cancel.
constexpr std::uint32_t Rounds = 3;
/// Distance from the centroid, over the radius of the mean vertex area element, below which vertices move: closer ones are
/// where samples have spots of the opposite color, about one vertex in a hundred.
constexpr double CentralPart = 0.05;
/// Least part of an edge that a vertex moves along, and the range of parts.
constexpr double LeastMove = 0.1;
constexpr double RangeOfMoves = 0.15;
/// Stream of the random numbers: choices of edges; that of the parts is the next.
constexpr std::uint32_t MoveStream = 0x52494e47;
/// Cosine of the angle between the normals of two triangles above which their edge is a crease: 60 degrees.
constexpr double CosineOfCreases = 0.5;

Eigen::RowVector3d NormalOf(const TriangleMesh& mesh, Index f)
{
  const Eigen::RowVector3d a = mesh.Points.row(mesh.Triangles(f, 0));
  const Eigen::RowVector3d b = mesh.Points.row(mesh.Triangles(f, 1));
  const Eigen::RowVector3d c = mesh.Points.row(mesh.Triangles(f, 2));
  return (b - a).cross(c - a).normalized();
}

/// Vertices at the other ends of the creases at vertex @p v.
std::vector<Index> CreasesAt(const TriangleMesh& mesh, const OneRings& rings, Index v)
{
  std::vector<Index> creases;
  const Index begin = rings.RingStart[v];
  const Index count = rings.RingStart[v + 1] - begin;
  for (Index k = rings.OnBoundary[v] ? 1 : 0; k < count; ++k)
  {
    const Index corner = rings.RingCorners[begin + k];
    const Index before = rings.RingCorners[begin + (k + count - 1) % count];
    if (NormalOf(mesh, corner / 3).dot(NormalOf(mesh, before / 3)) < CosineOfCreases)
    {
      creases.push_back(mesh.Triangles(corner / 3, (corner % 3 + 1) % 3));
    }
  }
  return creases;
}

/// Neighbor that vertex @p v moves towards; -1 for none.
Index TowardsNeighbor(const TriangleMesh& mesh, const OneRings& rings, const NormalKey& key, Index v)
{
  const std::vector<Index> creases = CreasesAt(mesh, rings, v);
  if (creases.size() > 2)
  {
    return -1;
  }
  if (!creases.empty())
  {
    return creases[static_cast<std::size_t>(UniformIndex(key, v, static_cast<std::int64_t>(creases.size())))];
  }
  const Index first = rings.NeighborStart[v];
  return rings.Neighbors[first + UniformIndex(key, v, rings.NeighborStart[v + 1] - first)];
}

/// Places in space that vertices move to, [N, 3].
PointMatrix MovedPoints(const WeldedSurface& welded, const std::vector<Index>& vertices, std::uint32_t round)
{
  const PointMatrix& points = welded.Mesh.Points;
  PointMatrix moved(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t k = 0; k < vertices.size(); ++k)
  {
    const Index v = vertices[k];
    const Index towards = TowardsNeighbor(welded.Mesh, welded.Rings, { 0, round, 0, MoveStream }, v);
    const double part = LeastMove + RangeOfMoves * Uniform({ 0, round, 0, MoveStream + 1 }, v);
    const Index end = towards < 0 ? v : towards;
    moved.row(static_cast<Eigen::Index>(k)) = points.row(v) + part * (points.row(end) - points.row(v));
  }
  return moved;
}
} // namespace

void MoveRegularVertices(const TriangleMesh& surface, Surface& triangulation, std::vector<SurfacePlace>& places)
{
  for (std::uint32_t round = 0; round < Rounds; ++round)
  {
    const WeldedSurface welded(triangulation);
    const std::vector<Index> central = CentralVertices(welded.Rings, CentralPart);
    if (central.empty())
    {
      return;
    }
    const std::vector<SurfacePlace> found = NearestPlaces(surface).Find(MovedPoints(welded, central, round));
    for (std::size_t p = 0; p < welded.VertexOfPoint.size(); ++p)
    {
      const auto vertex = std::lower_bound(central.begin(), central.end(), welded.VertexOfPoint[p]);
      if (vertex != central.end() && *vertex == welded.VertexOfPoint[p])
      {
        places[p] = found[static_cast<std::size_t>(vertex - central.begin())];
        triangulation.Mesh.Points.row(static_cast<Eigen::Index>(p)) = PositionOf(surface, places[p]).transpose();
      }
    }
  }
}

std::string DescribeRegularVertices(std::int64_t regular, std::int64_t vertices, const std::string& remedy)
{
  return regular == 0 ? ""
                      : std::to_string(regular) + " of " + std::to_string(vertices) +
      " vertices lie at the centroids of their rings, as those of regular grids do: the code of a flat color is 0 "
      "there, "
      "and the color is lost. " +
      remedy;
}

} // namespace surfsynth
