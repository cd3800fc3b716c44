// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TriangleAdjacency.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <utility>

namespace surfsynth
{

namespace
{
/// The side of triangle @p f that joins @p a and @p b, in any direction; the triangle must have it.
int SideOf(const TriangleMesh& mesh, Index f, Index a, Index b)
{
  const auto t = mesh.Triangles.row(f);
  for (int side = 0; side < 3; ++side)
  {
    if ((t(side) == a && t((side + 1) % 3) == b) || (t(side) == b && t((side + 1) % 3) == a))
    {
      return side;
    }
  }
  return 0;
}

/// The only other triangle on the edge of @p f between @p a and @p b.
Index OtherTriangle(const TriangleMesh& mesh, const MeshTopology& topology, Index f, Index a, Index b)
{
  const auto valence = [&](Index v) { return topology.VertexTriangleStart[v + 1] - topology.VertexTriangleStart[v]; };
  if (valence(b) < valence(a))
  {
    std::swap(a, b); // the pole of a globe has as many triangles as there are meridians
  }
  Index other = TriangleAdjacency::Boundary;
  for (Index k = topology.VertexTriangleStart[a]; k < topology.VertexTriangleStart[a + 1]; ++k)
  {
    const Index g = topology.VertexTriangles[k];
    if (g != f && (mesh.Triangles.row(g).array() == b).any())
    {
      if (other >= 0)
      {
        return TriangleAdjacency::Several;
      }
      other = g;
    }
  }
  return other;
}

/// A boundary edge: side @p Side of triangle @p Triangle.
struct BoundarySide
{
  Index Triangle;
  int Side;
};

/// The boundary edge that follows @p from at its end @p end, found by turning around that point from triangle to
/// triangle; its Triangle is negative where an edge with several triangles is in the way.
BoundarySide NextBoundarySide(
  const TriangleMesh& mesh, const TriangleAdjacency& adjacency, const BoundarySide& from, Index end)
{
  Index f = from.Triangle;
  int side = from.Side;
  while (true)
  {
    // The other side of f that has the point: the next one when the side ends there, else the one before.
    side = mesh.Triangles(f, (side + 1) % 3) == end ? (side + 1) % 3 : (side + 2) % 3;
    const Index beyond = adjacency.Across(f, side);
    if (beyond < 0)
    {
      return { beyond == TriangleAdjacency::Boundary ? f : -1, side };
    }
    const Index a = mesh.Triangles(f, side);
    const Index b = mesh.Triangles(f, (side + 1) % 3);
    side = SideOf(mesh, beyond, a, b);
    f = beyond;
  }
}

/// Walks from a boundary edge until the walk closes or ends, and marks its edges.
BoundaryLoop WalkAlong(
  const TriangleMesh& mesh, const TriangleAdjacency& adjacency, BoundarySide at, std::vector<bool>& walked)
{
  BoundaryLoop loop;
  loop.FirstPoint = mesh.Triangles(at.Triangle, at.Side);
  Index reached = loop.FirstPoint;
  while (at.Triangle >= 0 && !walked[3 * static_cast<std::size_t>(at.Triangle) + at.Side])
  {
    walked[3 * static_cast<std::size_t>(at.Triangle) + at.Side] = true;
    const Index a = mesh.Triangles(at.Triangle, at.Side);
    const Index b = mesh.Triangles(at.Triangle, (at.Side + 1) % 3);
    ++loop.Edges;
    loop.Length += (mesh.Points.row(a) - mesh.Points.row(b)).stableNorm();
    reached = a == reached ? b : a; // triangles may be wound in opposite senses
    at = NextBoundarySide(mesh, adjacency, at, reached);
  }
  return loop;
}
} // namespace

TriangleAdjacency::TriangleAdjacency(const TriangleMesh& mesh, const MeshTopology& topology)
  : Beyond(static_cast<std::size_t>(mesh.Triangles.size()))
{
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      for (int side = 0; side < 3; ++side)
      {
        this->Beyond[3 * f + side] = OtherTriangle(
          mesh, topology, static_cast<Index>(f), mesh.Triangles(f, side), mesh.Triangles(f, (side + 1) % 3));
      }
    }
  });
}

SurfacePatches FindPatches(const TriangleMesh& mesh, const TriangleAdjacency& adjacency)
{
  const Index triangles = mesh.NumberOfTriangles();
  SurfacePatches patches;
  patches.OfTriangle.assign(static_cast<std::size_t>(triangles), -1);
  patches.Sign.assign(static_cast<std::size_t>(triangles), 1);
  std::vector<Index> queue;
  for (Index first = 0; first < triangles; ++first)
  {
    if (patches.OfTriangle[first] >= 0)
    {
      continue;
    }
    bool orientable = true;
    queue.assign(1, first);
    patches.OfTriangle[first] = patches.Count;
    for (std::size_t head = 0; head < queue.size(); ++head)
    {
      const Index f = queue[head];
      for (int side = 0; side < 3; ++side)
      {
        const Index g = adjacency.Across(f, side);
        if (g < 0)
        {
          continue;
        }
        // Two triangles are wound alike when they run along their edge in opposite directions.
        const Index a = mesh.Triangles(f, side);
        const int other = SideOf(mesh, g, a, mesh.Triangles(f, (side + 1) % 3));
        const bool alike = mesh.Triangles(g, other) != a;
        const auto sign = static_cast<std::int8_t>(alike ? patches.Sign[f] : -patches.Sign[f]);
        if (patches.OfTriangle[g] < 0)
        {
          patches.OfTriangle[g] = patches.Count;
          patches.Sign[g] = sign;
          queue.push_back(g);
        }
        orientable = orientable && patches.Sign[g] == sign;
      }
    }
    patches.Orientable.push_back(orientable);
    ++patches.Count;
  }
  return patches;
}

std::vector<BoundaryLoop> FindBoundaryLoops(const TriangleMesh& mesh, const TriangleAdjacency& adjacency)
{
  std::vector<BoundaryLoop> loops;
  std::vector<bool> walked(static_cast<std::size_t>(mesh.Triangles.size()), false);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int side = 0; side < 3; ++side)
    {
      const bool onBoundary = adjacency.Across(f, side) == TriangleAdjacency::Boundary;
      if (onBoundary && !walked[3 * static_cast<std::size_t>(f) + side])
      {
        loops.push_back(WalkAlong(mesh, adjacency, { f, side }, walked));
      }
    }
  }
  return loops;
}

} // namespace surfsynth
