// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Graphs of sparse matrices, and coarser graphs of clusters of their vertices. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <vector>

namespace surfsynth
{

/// Undirected graph with V vertices and weights, compressed; each edge is stored at both of its ends.
struct WeightedGraph
{
  std::vector<Index> Start{ 0 };  ///< [V + 1], the neighbors of v are Neighbors[Start[v]] .. Neighbors[Start[v + 1])
  std::vector<Index> Neighbors;   ///< other ends of the edges
  std::vector<Index> EdgeWeights; ///< edges of the finest graph in each edge
  std::vector<Index> Weights;     ///< [V], vertices of the finest graph in each vertex

  /// Number of vertices, V.
  Index Size() const { return static_cast<Index>(this->Weights.size()); }
};

/// Clusters of the vertices of a graph.
struct VertexClusters
{
  std::vector<Index> Of; ///< [V], the cluster of each vertex
  Index Count = 0;       ///< number of clusters
};

/// Returns the graph of a symmetric matrix's entries off the diagonal, all weights 1.
WeightedGraph GraphOfPattern(const SparseMatrix& matrix);

/// Gathers vertices and their neighbors into clusters, greedily, in the order of vertices, in linear time. No cluster of
/// more than one vertex is heavier than @p mostWeight.
VertexClusters ClusterVertices(const WeightedGraph& graph, Index mostWeight);

/// Returns the graph of clusters: edges between the same two clusters are one.
WeightedGraph CoarsenGraph(const WeightedGraph& graph, const VertexClusters& clusters);

} // namespace surfsynth
