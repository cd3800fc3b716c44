// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Features of triangles and their neighbours in frames of their edges: the input features of [Hertz2020], section 3.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

namespace surfsynth
{

/// The triangles across the edges of each triangle. Edge i of a triangle runs from its corner i to corner (i + 1) % 3.
/// The neighbor across a boundary edge is the triangle itself, and the opposite vertex is its own.
struct FaceNeighbors
{
  TriangleMatrix Faces;    ///< [F, 3], the triangle across each edge
  TriangleMatrix Opposite; ///< [F, 3], the vertex of that triangle which is not on the edge
};

/// Finds the neighbors of all triangles.
/// @param mesh with manifold edges; any vertex degree, open or closed. O(F), parallel.
/// @throws InvalidInput when an edge has three triangles or more, an id is out of range or a triangle uses a vertex
/// twice.
FaceNeighbors ComputeFaceNeighbors(const TriangleMesh& mesh);
/// Finds the neighbors of all triangles of a mesh with tables. Same errors.
/// @param topology the tables of @p mesh
FaceNeighbors ComputeFaceNeighbors(const TriangleMesh& mesh, const MeshTopology& topology);

/// Former name of FaceNeighbors.
using FaceNeighbours [[deprecated("use FaceNeighbors")]] = FaceNeighbors;
/// Former name of ComputeFaceNeighbors().
[[deprecated("use ComputeFaceNeighbors()")]] inline FaceNeighbors ComputeFaceNeighbours(const TriangleMesh& mesh)
{
  return ComputeFaceNeighbors(mesh);
}
/// Former name of ComputeFaceNeighbors().
[[deprecated("use ComputeFaceNeighbors()")]] inline FaceNeighbors ComputeFaceNeighbours(
  const TriangleMesh& mesh, const MeshTopology& topology)
{
  return ComputeFaceNeighbors(mesh, topology);
}

/// Points in single precision, [V, 3], as networks see them.
using SinglePoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// [F, 12] float32, edge-major: for each edge the coordinates (x, y, n) of the opposite vertex in the edge's frame,
/// then the edge's length.
using EdgeFeatureMatrix = Eigen::Matrix<float, Eigen::Dynamic, 12, Eigen::RowMajor>;

/// Computes the edge features of a mesh. The frame of edge i has its origin at the midpoint, x along the edge, n the
/// face's unit normal (v1 - v0) x (v2 - v1), and y = x cross n, which points out of the triangle. Unit vectors of
/// triangles without area are zero (nothing is divided by 0). Beyond a boundary edge the opposite vertex is that of the
/// triangle itself, turned by half a turn around the midpoint of the edge: the surface goes on flat.
EdgeFeatureMatrix ComputeEdgeFeatures(
  const SinglePoints& points, const TriangleMatrix& triangles, const FaceNeighbors& neighbors);

/// Computes the displacement of each vertex: the mean over its corners of a x_i + b y_i + c n, with the frame of the
/// edge that leaves the corner and (a, b, c) the row of @p local for the triangle.
/// @param local [F, 3]
/// @return [V, 3]; 0 for vertices that no triangle uses
SinglePoints MeanCornerDisplacement(
  const SinglePoints& points, const TriangleMatrix& triangles, const Eigen::Ref<const SinglePoints>& local);

} // namespace surfsynth
