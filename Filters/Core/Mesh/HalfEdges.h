// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Half-edges of balanced meshes, grouped by edge. Private to the core.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Half-edge 3 f + k, from corner k of triangle f to corner k + 1; corner 3 f + k is its start.
using HalfEdge = std::int64_t;

/// Half-edge behind @p h in its triangle.
inline HalfEdge NextInTriangle(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
/// Vertex that half-edge @p h starts from.
inline Index StartOf(const TriangleMesh& mesh, HalfEdge h) { return mesh.Triangles(h / 3, h % 3); }
/// Vertex that half-edge @p h ends at.
inline Index EndOf(const TriangleMesh& mesh, HalfEdge h) { return StartOf(mesh, NextInTriangle(h)); }
/// Vertex of the triangle that does not lie on the half-edge.
inline Index ApexOf(const TriangleMesh& mesh, HalfEdge h) { return EndOf(mesh, NextInTriangle(h)); }
/// True when the half-edge runs from the lower to the higher id.
inline bool IsForward(const TriangleMesh& mesh, HalfEdge h) { return StartOf(mesh, h) < EndOf(mesh, h); }

/// Half-edges of a mesh, sorted by (lower id, higher id, half-edge), so that the half-edges of an edge are contiguous.
class EdgeGroups
{
public:
  /// Sorts the half-edges of @p mesh.
  /// @throws InvalidInput when an id is out of range or a triangle uses a point twice.
  explicit EdgeGroups(const TriangleMesh& mesh);

  std::vector<std::int64_t> Start; ///< [E + 1], first half-edge of each edge; the last entry is 3 F
  std::vector<HalfEdge> HalfEdges; ///< [3 F], by edge

  /// Number of edges, E.
  std::int64_t NumberOfEdges() const { return static_cast<std::int64_t>(this->Start.size()) - 1; }
  /// First half-edge of an edge.
  const HalfEdge* Begin(std::int64_t edge) const { return this->HalfEdges.data() + this->Start[edge]; }
  /// End of the half-edges of an edge.
  const HalfEdge* End(std::int64_t edge) const { return this->HalfEdges.data() + this->Start[edge + 1]; }
  /// Number of half-edges of an edge.
  std::int64_t Size(std::int64_t edge) const { return this->Start[edge + 1] - this->Start[edge]; }
};

/// Checks that each edge has as many triangles in one direction as in the other.
/// @throws InvalidInput naming @p function, the number of edges that are not balanced, and the first of them.
void RequireBalanced(const TriangleMesh& mesh, const EdgeGroups& edges, const char* function);

/// A mesh and its edges.
struct MeshWithEdges
{
  TriangleMesh Mesh; ///< the mesh
  EdgeGroups Edges;  ///< its half-edges
};

/// Removes the triangles of @p mesh that use a point twice, and the pairs of triangles on the same points that face
/// opposite ways.
MeshWithEdges WithoutFlatPairs(TriangleMesh mesh);

/// Removes the points of @p mesh that no triangle uses; the others keep their order.
TriangleMesh WithoutUnusedPoints(const TriangleMesh& mesh);

} // namespace surfsynth
