// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/NestedDissection.h"

#include "Core/Solvers/GraphCoarsening.h"
#include "Core/Solvers/GraphPartition.h"
#include "Core/Solvers/MinimumDegree.h"
#include "Core/Solvers/VertexCover.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace surfsynth
{

namespace
{
/// The finest graph and coarser ones, each of the clusters of the one before.
struct GraphLevels
{
  std::vector<WeightedGraph> Graphs;
  std::vector<VertexClusters> Clusters; ///< of the vertices of each graph but the last
};

/// Vertices of a graph that is not coarsened further.
constexpr Index CoarseEnough = 2000;

GraphLevels CoarsenByLevels(const SparseMatrix& matrix)
{
  constexpr double LargestRatio = 0.8;
  constexpr std::int64_t ClusterSize = 12; ///< times the mean weight
  GraphLevels levels;
  levels.Graphs.push_back(GraphOfPattern(matrix));
  const std::int64_t total = matrix.rows();
  while (levels.Graphs.back().Size() > CoarseEnough)
  {
    const WeightedGraph& graph = levels.Graphs.back();
    const std::int64_t most = std::min(total / 50 + 1, ClusterSize * total / graph.Size() + 1);
    VertexClusters clusters = ClusterVertices(graph, static_cast<Index>(most));
    if (clusters.Count > LargestRatio * graph.Size())
    {
      break;
    }
    WeightedGraph coarse = CoarsenGraph(graph, clusters);
    levels.Clusters.push_back(std::move(clusters));
    levels.Graphs.push_back(std::move(coarse));
  }
  return levels;
}

/// Leaves of the vertices of the finest graph. Leaves are split on the coarser graphs, where the few vertices of a leaf
/// stand for many, and cuts are moved on each graph. On the finest one leaves that grew by that are split again.
std::vector<Index> PartByLevels(const GraphLevels& levels, DissectionTree& tree)
{
  constexpr int TriesOnCoarsest = 12;
  constexpr int Tries = 2;
  const GraphPartition::SmallLeaf small;
  const GraphPartition::SmallLeaf finest{ 400, 400 };
  std::vector<Index> leaf(levels.Graphs.back().Weights.size(), 0);
  const bool isCoarse = levels.Graphs.back().Size() <= 2 * CoarseEnough; // graphs with hubs do not get there
  GraphPartition(levels.Graphs.back(), tree, leaf).SplitLeaves(isCoarse ? TriesOnCoarsest : Tries, small);
  for (std::size_t level = levels.Clusters.size(); level-- > 0;)
  {
    const std::vector<Index>& clusterOf = levels.Clusters[level].Of;
    std::vector<Index> fine(clusterOf.size());
    std::transform(clusterOf.begin(), clusterOf.end(), fine.begin(), [&](Index cluster) { return leaf[cluster]; });
    leaf = std::move(fine);
    GraphPartition partition(levels.Graphs[level], tree, leaf);
    partition.RefineCuts();
    partition.SplitLeaves(Tries, level > 0 ? small : finest);
  }
  return leaf;
}

/// An edge between the two sides of a node.
struct CutEdge
{
  Index Node;
  std::array<Index, 2> Ends; ///< on the first side, on the second
};

/// Edges between leaves, sorted by the nodes that part them.
std::vector<CutEdge> CutEdges(const WeightedGraph& graph, const DissectionTree& tree, const std::vector<Index>& leaf)
{
  std::vector<CutEdge> edges;
  for (Index v = 0; v < graph.Size(); ++v)
  {
    for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
    {
      const Index u = graph.Neighbors[k];
      if (leaf[u] == leaf[v] || tree.Path[leaf[v]] > tree.Path[leaf[u]]) // paths are in the order of sides
      {
        continue;
      }
      Index node = leaf[v];
      for (Index other = leaf[u]; node != other;)
      {
        Index& deeper = tree.Depth[node] >= tree.Depth[other] ? node : other;
        deeper = tree.Parent[deeper];
      }
      edges.push_back({ node, { v, u } });
    }
  }
  std::stable_sort(edges.begin(), edges.end(), [](const CutEdge& a, const CutEdge& b) { return a.Node < b.Node; });
  return edges;
}

/// Gives the vertices of each cut, a smallest cover of those edges that no cut above covers, to the node of the cut.
void MoveSeparatorsToNodes(const WeightedGraph& graph, const DissectionTree& tree, std::vector<Index>& nodeOf)
{
  const std::vector<CutEdge> edges = CutEdges(graph, tree, nodeOf);
  std::vector<Index> number(nodeOf.size(), -1);
  for (std::size_t k = 0; k < edges.size();)
  {
    const Index node = edges[k].Node;
    std::array<std::vector<Index>, 2> ends;
    std::vector<std::pair<Index, Index>> pairs;
    for (; k < edges.size() && edges[k].Node == node; ++k)
    {
      const std::array<Index, 2>& edge = edges[k].Ends;
      if (!tree.IsLeaf(nodeOf[edge[0]]) || !tree.IsLeaf(nodeOf[edge[1]]))
      {
        continue;
      }
      for (std::size_t side = 0; side < 2; ++side)
      {
        if (number[edge[side]] < 0)
        {
          number[edge[side]] = static_cast<Index>(ends[side].size());
          ends[side].push_back(edge[side]);
        }
      }
      pairs.emplace_back(number[edge[0]], number[edge[1]]);
    }
    const VertexCover cover = MinimumVertexCover(
      static_cast<Index>(ends[0].size()), static_cast<Index>(ends[1].size()), pairs);
    for (std::size_t side = 0; side < 2; ++side)
    {
      const std::vector<bool>& isCovering = side == 0 ? cover.Left : cover.Right;
      for (std::size_t end = 0; end < ends[side].size(); ++end)
      {
        const Index v = ends[side][end];
        number[v] = -1;
        nodeOf[v] = isCovering[end] ? node : nodeOf[v];
      }
    }
  }
}

/// Nodes of the tree, children before parents.
std::vector<Index> Postorder(const DissectionTree& tree)
{
  std::vector<Index> order;
  std::vector<Index> stack{ 0 };
  while (!stack.empty()) // parents before their children, the second child first: the reverse is a postorder
  {
    const Index node = stack.back();
    stack.pop_back();
    order.push_back(node);
    if (!tree.IsLeaf(node))
    {
      stack.push_back(tree.Left[node]);
      stack.push_back(tree.Left[node] + 1);
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Orders the vertices of leaves among themselves.
class LeafOrders
{
public:
  explicit LeafOrders(const WeightedGraph& graph)
    : Graph(graph)
    , Number(graph.Weights.size(), -1)
  {}

  void Order(Index* begin, Index* end)
  {
    this->Vertices.assign(begin, end);
    const auto own = static_cast<Index>(this->Vertices.size());
    for (Index k = 0; k < own; ++k)
    {
      this->Number[this->Vertices[k]] = k;
    }
    for (Index k = 0; k < own; ++k) // the neighbors outside, numbered behind
    {
      this->ForNeighbors(this->Vertices[k], [&](Index u) {
        if (this->Number[u] < 0)
        {
          this->Number[u] = static_cast<Index>(this->Vertices.size());
          this->Vertices.push_back(u);
        }
      });
    }
    this->Elimination.Begin(own, static_cast<Index>(this->Vertices.size()) - own);
    for (Index k = 0; k < own; ++k)
    {
      this->ForNeighbors(this->Vertices[k], [&](Index u) { this->Elimination.Connect(k, this->Number[u]); });
    }
    const std::vector<Index>& order = this->Elimination.Order();
    std::transform(order.begin(), order.end(), begin, [&](Index k) { return this->Vertices[k]; });
    for (const Index v : this->Vertices)
    {
      this->Number[v] = -1;
    }
  }

private:
  template <typename Function>
  void ForNeighbors(Index vertex, const Function& function) const
  {
    std::for_each(this->Graph.Neighbors.begin() + this->Graph.Start[vertex],
      this->Graph.Neighbors.begin() + this->Graph.Start[vertex + 1], function);
  }

  const WeightedGraph& Graph;
  std::vector<Index> Number; ///< [V], in the leaf at hand
  std::vector<Index> Vertices;
  MinimumDegree Elimination;
};
} // namespace

std::vector<Index> NestedDissectionOrder(const SparseMatrix& matrix)
{
  const GraphLevels levels = CoarsenByLevels(matrix);
  const WeightedGraph& graph = levels.Graphs.front();
  DissectionTree tree;
  std::vector<Index> nodeOf = PartByLevels(levels, tree);
  MoveSeparatorsToNodes(graph, tree, nodeOf);

  std::vector<Index> sizes(static_cast<std::size_t>(tree.Size()), 0);
  for (const Index node : nodeOf)
  {
    ++sizes[node];
  }
  const std::vector<Index> nodes = Postorder(tree);
  std::vector<Index> next(static_cast<std::size_t>(tree.Size()));
  Index place = 0;
  for (const Index node : nodes)
  {
    next[node] = place;
    place += sizes[node];
  }
  std::vector<Index> order(nodeOf.size());
  for (Index v = 0; v < graph.Size(); ++v)
  {
    order[next[nodeOf[v]]++] = v;
  }
  LeafOrders leaves(graph);
  for (const Index node : nodes)
  {
    if (tree.IsLeaf(node))
    {
      leaves.Order(order.data() + next[node] - sizes[node], order.data() + next[node]);
    }
  }
  return order;
}

} // namespace surfsynth
