// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/GraphCoarsening.h"

#include <algorithm>
#include <numeric>

namespace surfsynth
{

WeightedGraph GraphOfPattern(const SparseMatrix& matrix)
{
  WeightedGraph graph;
  graph.Neighbors.reserve(static_cast<std::size_t>(matrix.nonZeros()));
  graph.Start.reserve(static_cast<std::size_t>(matrix.rows()) + 1);
  for (Index v = 0; v < matrix.rows(); ++v)
  {
    for (SparseMatrix::InnerIterator entry(matrix, v); entry; ++entry)
    {
      if (entry.row() != v)
      {
        graph.Neighbors.push_back(static_cast<Index>(entry.row()));
      }
    }
    graph.Start.push_back(static_cast<Index>(graph.Neighbors.size()));
  }
  graph.EdgeWeights.assign(graph.Neighbors.size(), 1);
  graph.Weights.assign(static_cast<std::size_t>(matrix.rows()), 1);
  return graph;
}

namespace
{
/// Weights of the edges of one vertex to each label, in the order of their first edges.
class EdgeSums
{
public:
  explicit EdgeSums(Index labels)
    : Sums(static_cast<std::size_t>(labels), 0)
  {}
  void Add(Index label, Index weight)
  {
    if (this->Sums[label] == 0)
    {
      this->Touched.push_back(label);
    }
    this->Sums[label] += weight;
  }
  const std::vector<Index>& Labels() const { return this->Touched; }
  Index operator[](Index label) const { return this->Sums[label]; }
  void Clear()
  {
    for (const Index label : this->Touched)
    {
      this->Sums[label] = 0;
    }
    this->Touched.clear();
  }

private:
  std::vector<Index> Sums;
  std::vector<Index> Touched;
};

/// Clusters of a vertex, none of whose neighbors is in one, with its neighbors; other vertices get -1. Returns weights.
std::vector<Index> ClusterNeighborhoods(const WeightedGraph& graph, Index mostWeight, std::vector<Index>& cluster)
{
  std::vector<Index> weights;
  for (Index v = 0; v < graph.Size(); ++v)
  {
    const Index* begin = graph.Neighbors.data() + graph.Start[v];
    const Index* end = graph.Neighbors.data() + graph.Start[v + 1];
    const auto taken = [&](Index u) { return cluster[u] >= 0; };
    if (taken(v) || std::any_of(begin, end, taken))
    {
      continue;
    }
    cluster[v] = static_cast<Index>(weights.size());
    Index weight = graph.Weights[v];
    for (const Index* u = begin; u != end; ++u)
    {
      if (weight + graph.Weights[*u] <= mostWeight)
      {
        weight += graph.Weights[*u];
        cluster[*u] = cluster[v];
      }
    }
    weights.push_back(weight);
  }
  return weights;
}
} // namespace

VertexClusters ClusterVertices(const WeightedGraph& graph, Index mostWeight)
{
  VertexClusters clusters;
  clusters.Of.assign(graph.Weights.size(), -1);
  std::vector<Index> weights = ClusterNeighborhoods(graph, mostWeight, clusters.Of);
  // The rest joins the clusters to which it has most edges, the lightest one of those.
  EdgeSums sums(graph.Size());
  for (Index v = 0; v < graph.Size(); ++v)
  {
    if (clusters.Of[v] >= 0)
    {
      continue;
    }
    for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
    {
      const Index cluster = clusters.Of[graph.Neighbors[k]];
      if (cluster >= 0 && weights[cluster] + graph.Weights[v] <= mostWeight)
      {
        sums.Add(cluster, graph.EdgeWeights[k]);
      }
    }
    Index best = -1;
    for (const Index c : sums.Labels())
    {
      if (best < 0 || sums[c] > sums[best] || (sums[c] == sums[best] && weights[c] < weights[best]))
      {
        best = c;
      }
    }
    sums.Clear();
    if (best < 0)
    {
      best = static_cast<Index>(weights.size());
      weights.push_back(0);
    }
    clusters.Of[v] = best;
    weights[best] += graph.Weights[v];
  }
  clusters.Count = static_cast<Index>(weights.size());
  return clusters;
}

WeightedGraph CoarsenGraph(const WeightedGraph& graph, const VertexClusters& clusters)
{
  std::vector<Index> start(static_cast<std::size_t>(clusters.Count) + 1, 0);
  for (const Index c : clusters.Of)
  {
    ++start[c + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Index> members(clusters.Of.size());
  std::vector<Index> next(start.begin(), start.end() - 1);
  for (Index v = 0; v < graph.Size(); ++v)
  {
    members[next[clusters.Of[v]]++] = v;
  }

  WeightedGraph coarse;
  coarse.Weights.assign(static_cast<std::size_t>(clusters.Count), 0);
  EdgeSums sums(clusters.Count);
  for (Index c = 0; c < clusters.Count; ++c)
  {
    for (Index m = start[c]; m < start[c + 1]; ++m)
    {
      const Index v = members[m];
      coarse.Weights[c] += graph.Weights[v];
      for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
      {
        if (clusters.Of[graph.Neighbors[k]] != c)
        {
          sums.Add(clusters.Of[graph.Neighbors[k]], graph.EdgeWeights[k]);
        }
      }
    }
    for (const Index other : sums.Labels())
    {
      coarse.Neighbors.push_back(other);
      coarse.EdgeWeights.push_back(sums[other]);
    }
    sums.Clear();
    coarse.Start.push_back(static_cast<Index>(coarse.Neighbors.size()));
  }
  return coarse;
}

} // namespace surfsynth
