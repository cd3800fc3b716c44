// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Which vertices and triangles touch: the tables behind the mesh check and the assembly of operators.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// Incidence tables of a triangle mesh in compressed rows, built in O(V + F), in parallel.
///
/// The ids of the mesh must be in range and no triangle may use a vertex twice (CheckMesh() finds both).
class MeshTopology
{
public:
  /// @throws InvalidInput when an id is out of range or a triangle uses a vertex twice.
  explicit MeshTopology(const TriangleMesh& mesh);

  /// Triangles around vertex v, ascending, are VertexTriangles[VertexTriangleStart[v] .. VertexTriangleStart[v + 1]).
  std::vector<Index> VertexTriangleStart; ///< [V + 1]
  std::vector<Index> VertexTriangles;     ///< [3 F]
  /// Where corner k of triangle f stands in VertexTriangles: CornerPlace[3 f + k]. What a triangle does to its vertices
  /// can so be written in the order of triangles, in parallel, and read in the order of vertices.
  std::vector<Index> CornerPlace; ///< [3 F]

  /// Vertices joined to v by an edge, ascending, are Neighbours[NeighbourStart[v] .. NeighbourStart[v + 1]).
  std::vector<Index> NeighbourStart; ///< [V + 1]
  std::vector<Index> Neighbours;     ///< [2 E]
  /// Number of triangles on the edge to that neighbour (1 = boundary, 2 = inside, 3 or more = non-manifold),
  /// saturated at 255.
  std::vector<std::uint8_t> EdgeTriangles; ///< [2 E]

  Index NumberOfPoints() const { return static_cast<Index>(this->VertexTriangleStart.size()) - 1; }
  std::int64_t NumberOfEdges() const { return static_cast<std::int64_t>(this->Neighbours.size()) / 2; }

private:
  void PlaceCorners(const TriangleMesh& mesh);
  void FindNeighbours(const TriangleMesh& mesh);
};

/// The connected components of a mesh; vertices that no triangle uses belong to none.
struct MeshComponents
{
  Index Count = 0;
  std::vector<Index> OfVertex; ///< [V], component of each vertex in order of its lowest vertex id, -1 when unused
  std::vector<double> Area;    ///< [Count], square world units
  std::vector<std::int64_t> EulerCharacteristic; ///< [Count], V - E + F
  std::vector<bool> Closed;                      ///< [Count], true when no edge lies on a boundary
};

/// Finds the components in O(V + F). @p mass is the lumped mass, whose sum over a component is its area.
MeshComponents ComputeComponents(const MeshTopology& topology, const Eigen::VectorXd& mass);

} // namespace surfsynth
