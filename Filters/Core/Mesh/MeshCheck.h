// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The gate: one check of a triangle mesh that every algorithm of the library shares.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// What can be wrong with a triangle mesh. The first four break every algorithm and are always looked for; the others
/// only when MeshRequirements asks.
enum class MeshDefect
{
  IndexOutOfRange,     ///< a triangle names a vertex that does not exist; ids are triangles
  NonFinitePoint,      ///< a used vertex has a NaN or infinite coordinate; ids are vertices
  RepeatedVertex,      ///< a triangle uses a vertex twice; ids are triangles
  DegenerateTriangle,  ///< a triangle's area is zero (below 1e-12 of its longest edge squared); ids are triangles
  NonManifoldEdge,     ///< three or more triangles share an edge; ids are the lower vertex of the edge
  NonManifoldVertex,   ///< the triangles around a vertex form several fans; ids are vertices
  InconsistentWinding, ///< two triangles run along their edge in the same direction; ids are its lower vertex
  BoundaryEdge,        ///< an edge has only one triangle; ids are the lower vertex of the edge
  SeveralComponents ///< the mesh is not connected; the count is the number of components, the id a vertex of the second
};

/// The conditions beyond finite, in-range, non-degenerate triangles that an algorithm needs.
struct MeshRequirements
{
  bool ManifoldEdges = true;
  bool ManifoldVertices = false;
  bool ConsistentWinding = false;
  bool Closed = false;
  bool SingleComponent = false;
};

/// One kind of defect found in a mesh.
struct MeshFinding
{
  MeshDefect Defect;
  std::int64_t Count = 0; ///< how many
  std::int64_t First = 0; ///< the first id
};

/// Everything found wrong with @p mesh, in the order of MeshDefect. A later kind is only looked for while the mesh is
/// sound enough to do so (ids in range before geometry, geometry before edges). Empty means sound. O(V + F), parallel.
std::vector<MeshFinding> CheckMesh(const TriangleMesh& mesh, const MeshRequirements& requirements = {});

/// True when the ids of a finding of this kind are triangles, false when they are vertices.
bool HasTriangleIds(MeshDefect defect);

/// True when the area of triangle @p f, whose ids are in range, is zero for MeshDefect::DegenerateTriangle.
bool IsDegenerateTriangle(const TriangleMesh& mesh, std::int64_t f);

/// True when the triangles around vertex @p v form one fan or one ring, or there are none.
bool HasSingleFan(const TriangleMesh& mesh, const MeshTopology& topology, std::int64_t v);

/// The triangles of a mesh whose corners are three different vertices that exist: those that MeshTopology takes.
struct ProperTriangles
{
  TriangleMesh Mesh;           ///< all points, and those triangles
  std::vector<Index> Original; ///< [F], the id that each of them has in the whole mesh, ascending
};
ProperTriangles KeepProperTriangles(const TriangleMesh& mesh);

/// Every kind of defect of @p mesh, in the order of MeshDefect. Unlike CheckMesh(), goes on after a defect: triangles with
/// broken ids count as absent in all that follows. @p proper and @p topology are those of @p mesh.
std::vector<MeshFinding> InspectMesh(
  const TriangleMesh& mesh, const ProperTriangles& proper, const MeshTopology& topology);

/// What repairs a defect, as DescribeFindings() says it: "vtkSurfaceRepairFilter or vtkCleanPolyData removes them."
std::string RepairOf(MeshDefect defect);

/// A sentence for each finding: what, how many, the first id and the VTK filter that repairs it. @p cellOfTriangle
/// turns triangle ids into the caller's cell ids; empty when they are the same.
std::string DescribeFindings(
  const std::vector<MeshFinding>& findings, const std::function<std::int64_t(std::int64_t)>& cellOfTriangle = {});

/// The tables of a mesh in which CheckMesh() finds nothing, so that who checks need not build them again.
/// @throws InvalidInput with DescribeFindings() when it finds anything.
MeshTopology RequireValidMesh(const TriangleMesh& mesh, const MeshRequirements& requirements = {},
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle = {});

} // namespace surfsynth
