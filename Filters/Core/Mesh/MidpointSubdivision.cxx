// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/MidpointSubdivision.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/HalfEdges.h"

#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
void RequireRoom(std::int64_t count, const char* what)
{
  if (count > std::numeric_limits<Index>::max())
  {
    throw InvalidInput("SubdivideAtMidpoints: the result would have " + std::to_string(count) + " " + what +
      "; at most 2147483647 are expected.");
  }
}

/// The midpoint on each half-edge, [3 F], numbered from @p first in order of appearance; fills @p parents.
std::vector<Index> NumberMidpoints(
  const TriangleMesh& mesh, const EdgeGroups& edges, Index first, std::vector<std::array<Index, 2>>& parents)
{
  // Half-edges of an edge stand in ascending order, so each points to the first of its edge, which comes before it.
  std::vector<HalfEdge> firstOfEdge(edges.HalfEdges.size());
  ParallelFor(edges.NumberOfEdges(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e)
    {
      for (const HalfEdge* h = edges.Begin(e); h != edges.End(e); ++h)
      {
        firstOfEdge[*h] = *edges.Begin(e);
      }
    }
  });
  std::vector<Index> midpoints(firstOfEdge.size());
  parents.reserve(static_cast<std::size_t>(edges.NumberOfEdges()));
  for (HalfEdge h = 0; h < static_cast<HalfEdge>(midpoints.size()); ++h)
  {
    if (firstOfEdge[h] == h)
    {
      midpoints[h] = first + static_cast<Index>(parents.size());
      parents.push_back({ StartOf(mesh, h), EndOf(mesh, h) });
    }
    else
    {
      midpoints[h] = midpoints[firstOfEdge[h]];
    }
  }
  return midpoints;
}
} // namespace

SubdividedMesh SubdivideAtMidpoints(const TriangleMesh& mesh)
{
  const Index points = mesh.NumberOfPoints();
  const Index faces = mesh.NumberOfTriangles();
  RequireRoom(4 * std::int64_t(faces), "triangles");
  const EdgeGroups edges(mesh);
  RequireRoom(points + edges.NumberOfEdges(), "vertices");
  SubdividedMesh result;
  const std::vector<Index> midpoints = NumberMidpoints(mesh, edges, points, result.Parents);
  TriangleMatrix& triangles = result.Mesh.Triangles;
  triangles.resize(4 * Eigen::Index(faces), 3);
  ParallelFor(faces, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const auto v = mesh.Triangles.row(f);
      const Index* m = midpoints.data() + 3 * f;
      triangles.row(f) << v(0), m[0], m[2];
      triangles.row(f + faces) << v(1), m[1], m[0];
      triangles.row(f + 2 * Eigen::Index(faces)) << v(2), m[2], m[1];
      triangles.row(f + 3 * Eigen::Index(faces)) << m[0], m[1], m[2];
    }
  });
  result.Mesh.Points.resize(points + static_cast<Eigen::Index>(result.Parents.size()), 3);
  result.Mesh.Points.topRows(points) = mesh.Points;
  ParallelFor(static_cast<std::int64_t>(result.Parents.size()), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e)
    {
      const auto& [a, b] = result.Parents[e];
      result.Mesh.Points.row(points + e) = 0.5 * mesh.Points.row(a) + 0.5 * mesh.Points.row(b);
    }
  });
  return result;
}

} // namespace surfsynth
