// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Incidence tables of vertices and triangles, for the mesh check and the assembly of operators.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Incidence tables of a triangle mesh in compressed rows, built in O(V + F), in parallel.
///
/// The ids of the mesh must be in range and no triangle may use a vertex twice (CheckMesh() finds both).
class MeshTopology
{
public:
  /// Builds the tables of @p mesh.
  /// @throws InvalidInput when an id is out of range or a triangle uses a vertex twice.
  explicit MeshTopology(const TriangleMesh& mesh);

  /// Triangles around vertex v, ascending, are VertexTriangles[VertexTriangleStart[v] .. VertexTriangleStart[v + 1]).
  std::vector<Index> VertexTriangleStart; ///< [V + 1]
  std::vector<Index> VertexTriangles;     ///< [3 F]
  /// Index of corner k of triangle f in VertexTriangles: CornerPlace[3 f + k]. With it, contributions of triangles to
  /// vertices are written in the order of triangles, in parallel, and read in the order of vertices.
  std::vector<Index> CornerPlace; ///< [3 F]

  /// Vertices joined to v by an edge, ascending, are Neighbors[NeighborStart[v] .. NeighborStart[v + 1]).
  std::vector<Index> NeighborStart; ///< [V + 1]
  std::vector<Index> Neighbors;     ///< [2 E]
  /// Number of triangles on the edge to that neighbour (1 = boundary, 2 = inside, 3 or more = non-manifold),
  /// saturated at 255.
  std::vector<std::uint8_t> EdgeTriangles; ///< [2 E]

  /// True for vertices with an edge of a single triangle.
  bool IsOnBoundary(Index v) const
  {
    const auto first = this->EdgeTriangles.begin();
    return std::count(first + this->NeighborStart[v], first + this->NeighborStart[v + 1], 1) > 0;
  }

  /// Number of vertices, V.
  Index NumberOfPoints() const { return static_cast<Index>(this->VertexTriangleStart.size()) - 1; }
  /// Number of edges, E.
  std::int64_t NumberOfEdges() const { return static_cast<std::int64_t>(this->Neighbors.size()) / 2; }

private:
  void PlaceCorners(const TriangleMesh& mesh);
  void FindNeighbors(const TriangleMesh& mesh);
};

/// The connected components of a mesh; vertices that no triangle uses belong to none.
struct MeshComponents
{
  Index Count = 0;             ///< number of components
  std::vector<Index> OfVertex; ///< [V], component of each vertex in order of its lowest vertex id, -1 when unused
  std::vector<double> Area;    ///< [Count], square world units
  std::vector<std::int64_t> EulerCharacteristic; ///< [Count], V - E + F
  std::vector<bool> Closed;                      ///< [Count], true when no edge lies on a boundary
};

/// Finds the components, in O(V + F).
/// @param mass [V], the lumped mass; its sum over a component is the component's area
MeshComponents ComputeComponents(const MeshTopology& topology, const Eigen::VectorXd& mass);

} // namespace surfsynth
