// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Between the core's triangle mesh and CGAL's. Private to the meshing module.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

namespace surfsynth
{

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = CgalKernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;
using CgalVertex = CgalMesh::Vertex_index;
using CgalEdge = CgalMesh::Edge_index;
using CgalHalfedge = CgalMesh::Halfedge_index;
using CgalFace = CgalMesh::Face_index;

inline CgalPoint ToCgalPoint(const Eigen::Vector3d& point) { return { point.x(), point.y(), point.z() }; }
inline Eigen::Vector3d FromCgalPoint(const CgalPoint& point) { return { point.x(), point.y(), point.z() }; }

/// The same mesh as a halfedge structure: vertex v and face f have the indices v and f.
/// @throws InvalidInput when @p mesh is not manifold or not consistently wound.
CgalMesh ToCgalMesh(const TriangleMesh& mesh);

/// The mesh without what was removed from it, in the order of CGAL's indices. Points that no face uses are left out.
TriangleMesh FromCgalMesh(const CgalMesh& mesh);

} // namespace surfsynth
