// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Half-edges of balanced meshes, grouped by edge. Private to the core.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Half-edge 3 f + k runs from corner k of triangle f to corner k + 1; corner 3 f + k is the corner that it starts from.
using HalfEdge = std::int64_t;

inline HalfEdge NextInTriangle(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline Index StartOf(const TriangleMesh& mesh, HalfEdge h) { return mesh.Triangles(h / 3, h % 3); }
inline Index EndOf(const TriangleMesh& mesh, HalfEdge h) { return StartOf(mesh, NextInTriangle(h)); }
/// The corner of the triangle that does not lie on the half-edge.
inline Index ApexOf(const TriangleMesh& mesh, HalfEdge h) { return EndOf(mesh, NextInTriangle(h)); }
/// True when it runs from the lower to the higher id.
inline bool IsForward(const TriangleMesh& mesh, HalfEdge h) { return StartOf(mesh, h) < EndOf(mesh, h); }

/// The half-edges of a mesh, sorted by (lower id, higher id, half-edge): those of an edge stand together.
class EdgeGroups
{
public:
  /// @throws InvalidInput when an id is out of range or a triangle uses a point twice.
  explicit EdgeGroups(const TriangleMesh& mesh);

  /// Where edge e begins, with the number of half-edges at the end: [E + 1].
  std::vector<std::int64_t> Start;
  std::vector<HalfEdge> HalfEdges; ///< [3 F]

  std::int64_t NumberOfEdges() const { return static_cast<std::int64_t>(this->Start.size()) - 1; }
  const HalfEdge* Begin(std::int64_t edge) const { return this->HalfEdges.data() + this->Start[edge]; }
  const HalfEdge* End(std::int64_t edge) const { return this->HalfEdges.data() + this->Start[edge + 1]; }
  std::int64_t Size(std::int64_t edge) const { return this->Start[edge + 1] - this->Start[edge]; }
};

/// Throws InvalidInput naming @p function, how many edges have not as many triangles in one direction as in the other,
/// and the first of them, when there is one.
void RequireBalanced(const TriangleMesh& mesh, const EdgeGroups& edges, const char* function);

/// A mesh with its edges.
struct MeshWithEdges
{
  TriangleMesh Mesh;
  EdgeGroups Edges;
};

/// @p mesh without triangles that use a point twice, and without pairs of triangles on the same points that face
/// opposite ways.
MeshWithEdges WithoutFlatPairs(TriangleMesh mesh);

/// @p mesh without the points that no triangle uses.
TriangleMesh WithoutUnusedPoints(const TriangleMesh& mesh);

} // namespace surfsynth
