// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The mesh check that every algorithm of the library shares.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Defects of a triangle mesh. The first four break every algorithm and are always looked for; the others only when
/// MeshRequirements asks.
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

/// Requirements of an algorithm beyond finite, in-range, non-degenerate triangles.
struct MeshRequirements
{
  bool ManifoldEdges = true;      ///< no MeshDefect::NonManifoldEdge
  bool ManifoldVertices = false;  ///< no MeshDefect::NonManifoldVertex
  bool ConsistentWinding = false; ///< no MeshDefect::InconsistentWinding
  bool Closed = false;            ///< no MeshDefect::BoundaryEdge
  bool SingleComponent = false;   ///< no MeshDefect::SeveralComponents
};

/// One kind of defect found in a mesh.
struct MeshFinding
{
  MeshDefect Defect;      ///< kind
  std::int64_t Count = 0; ///< number of triangles, vertices, edges or components with it
  std::int64_t First = 0; ///< the first id; see MeshDefect for its kind
};

/// Finds the defects of @p mesh, in the order of MeshDefect. Looks for a later kind only while no earlier one prevents
/// it (ids before geometry, geometry before edges). O(V + F), parallel.
/// @return one finding for each kind of defect; empty for a valid mesh.
std::vector<MeshFinding> CheckMesh(const TriangleMesh& mesh, const MeshRequirements& requirements = {});

/// True when the ids of a finding of this kind are triangles, false when they are vertices.
bool HasTriangleIds(MeshDefect defect);

/// True when triangle @p f, whose ids are in range, has MeshDefect::DegenerateTriangle.
bool IsDegenerateTriangle(const TriangleMesh& mesh, std::int64_t f);

/// True when the triangles around vertex @p v form one fan or one ring, or there are none.
bool HasSingleFan(const TriangleMesh& mesh, const MeshTopology& topology, std::int64_t v);

/// The proper triangles of a mesh, which MeshTopology takes: their corners are three different vertices that exist.
struct ProperTriangles
{
  TriangleMesh Mesh;           ///< all points, and the proper triangles
  std::vector<Index> Original; ///< [F], id of each proper triangle in the whole mesh, ascending
};
/// Finds the proper triangles of any mesh.
ProperTriangles KeepProperTriangles(const TriangleMesh& mesh);

/// Finds every kind of defect of @p mesh, in the order of MeshDefect. Unlike CheckMesh(), goes on after a defect:
/// triangles with invalid ids count as absent from there on.
/// @param proper the proper triangles of @p mesh
/// @param topology the tables of @p proper
std::vector<MeshFinding> InspectMesh(
  const TriangleMesh& mesh, const ProperTriangles& proper, const MeshTopology& topology);

/// Sentence about the repair of a defect, for DescribeFindings(): "vtkSurfaceRepairFilter or vtkCleanPolyData removes
/// them."
std::string RepairOf(MeshDefect defect);

/// Sentences about the findings, one for each: the defect, its number, the first id and the VTK filter that repairs it.
/// @param cellOfTriangle turns triangle ids into the caller's cell ids; empty when they are the same
std::string DescribeFindings(
  const std::vector<MeshFinding>& findings, const std::function<std::int64_t(std::int64_t)>& cellOfTriangle = {});

/// Checks a mesh and returns its tables, which the check has built.
/// @throws InvalidInput with DescribeFindings() as text when CheckMesh() finds a defect.
MeshTopology RequireValidMesh(const TriangleMesh& mesh, const MeshRequirements& requirements = {},
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle = {});

} // namespace surfsynth
