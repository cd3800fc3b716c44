// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion between TriangleMesh and CGAL's Surface_mesh. Private to the mesh processing.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

namespace surfsynth
{

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel; ///< float64 points, exact predicates
using CgalPoint = CgalKernel::Point_3;                                  ///< a point
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;                         ///< a halfedge structure
using CgalVertex = CgalMesh::Vertex_index;                              ///< id of a vertex
using CgalEdge = CgalMesh::Edge_index;                                  ///< id of an edge
using CgalHalfedge = CgalMesh::Halfedge_index;                          ///< id of a halfedge
using CgalFace = CgalMesh::Face_index;                                  ///< id of a face

/// Converts a point.
inline CgalPoint ToCgalPoint(const Eigen::Vector3d& point) { return { point.x(), point.y(), point.z() }; }
/// Converts a point back.
inline Eigen::Vector3d FromCgalPoint(const CgalPoint& point) { return { point.x(), point.y(), point.z() }; }

/// Converts a mesh to a halfedge structure: vertex v and face f have the indices v and f.
/// @throws InvalidInput when @p mesh is not manifold or not consistently wound.
CgalMesh ToCgalMesh(const TriangleMesh& mesh);

/// Converts a halfedge structure without its removed elements, in the order of CGAL's indices. Points that no face uses
/// are left out.
TriangleMesh FromCgalMesh(const CgalMesh& mesh);

} // namespace surfsynth
