// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/GraphPartition.h"

#include <algorithm>
#include <iterator>

namespace surfsynth
{

namespace
{
constexpr double SmallestShare = 0.35; ///< of a side in the weight of both
constexpr int MostRounds = 4;
constexpr std::size_t Patience = 10; ///< moves without a saving, and a quarter of the vertices at the cut
} // namespace

void DissectionTree::Split(Index node)
{
  this->Left[node] = this->Size();
  for (std::uint64_t side = 0; side < 2; ++side)
  {
    this->Parent.push_back(node);
    this->Left.push_back(-1);
    this->Path.push_back(this->Path[node] | side << (63 - this->Depth[node]));
    this->Depth.push_back(this->Depth[node] + 1);
  }
}

GraphPartition::GraphPartition(const WeightedGraph& graph, DissectionTree& tree, std::vector<Index>& leaf)
  : Graph(graph)
  , Tree(tree)
  , Leaf(leaf)
  , Weight(static_cast<std::size_t>(tree.Size()), 0)
  , Gains(static_cast<std::size_t>(graph.Size()), 0)
  , Stamps(static_cast<std::size_t>(graph.Size()), -1)
  , EdgesTo(static_cast<std::size_t>(tree.Size()), 0)
{
  for (Index v = 0; v < graph.Size(); ++v)
  {
    this->Weight[leaf[v]] += graph.Weights[v];
  }
  for (Index node = tree.Size(); node-- > 1;)
  {
    this->Weight[tree.Parent[node]] += this->Weight[node];
  }
}

int GraphPartition::Side(const Cut& cut, Index vertex) const
{
  const std::uint64_t path = this->Tree.Path[this->Leaf[vertex]];
  if (cut.Depth > 0 && (path ^ cut.Path) >> (64 - cut.Depth) != 0)
  {
    return -1;
  }
  return static_cast<int>(path >> (63 - cut.Depth) & 1);
}

void GraphPartition::Push(Index vertex)
{
  this->Heap.emplace_back(this->Gains[vertex], vertex);
  std::push_heap(this->Heap.begin(), this->Heap.end());
}

Index GraphPartition::Pop()
{
  while (!this->Heap.empty())
  {
    const auto [gain, vertex] = this->Heap.front();
    std::pop_heap(this->Heap.begin(), this->Heap.end());
    this->Heap.pop_back();
    if (this->Stamps[vertex] == 2 * this->Round && this->Gains[vertex] == gain)
    {
      return vertex;
    }
  }
  return -1;
}

void GraphPartition::Assign(Index vertex, Index leaf, Index top)
{
  for (Index node = this->Leaf[vertex]; node != top; node = this->Tree.Parent[node])
  {
    this->Weight[node] -= this->Graph.Weights[vertex];
  }
  for (Index node = leaf; node != top; node = this->Tree.Parent[node])
  {
    this->Weight[node] += this->Graph.Weights[vertex];
  }
  this->Leaf[vertex] = leaf;
}

Index GraphPartition::Gain(const Cut& cut, Index vertex) const
{
  const int side = this->Side(cut, vertex);
  Index gain = 0;
  for (Index k = this->Graph.Start[vertex]; k < this->Graph.Start[vertex + 1]; ++k)
  {
    const int other = this->Side(cut, this->Graph.Neighbors[k]);
    if (other >= 0)
    {
      gain += other == side ? -this->Graph.EdgeWeights[k] : this->Graph.EdgeWeights[k];
    }
  }
  return gain;
}

bool GraphPartition::IsAtCut(const Cut& cut, Index vertex) const
{
  const int side = this->Side(cut, vertex);
  const auto isAcross = [&](Index neighbor) { return this->Side(cut, neighbor) == 1 - side; };
  return side >= 0 &&
    std::any_of(this->Graph.Neighbors.begin() + this->Graph.Start[vertex],
      this->Graph.Neighbors.begin() + this->Graph.Start[vertex + 1], isAcross);
}

std::int64_t GraphPartition::EdgesCut(const Cut& cut, const std::vector<Index>& vertices) const
{
  std::int64_t sum = 0;
  for (const Index v : vertices)
  {
    for (Index k = this->Graph.Start[v]; k < this->Graph.Start[v + 1]; ++k)
    {
      const bool isCut = this->Side(cut, v) == 0 && this->Side(cut, this->Graph.Neighbors[k]) == 1;
      sum += isCut ? this->Graph.EdgeWeights[k] : 0;
    }
  }
  return sum;
}

Index GraphPartition::NearestLeafAcross(const Cut& cut, Index vertex)
{
  const int side = this->Side(cut, vertex);
  Index nearest = -1;
  const Index begin = this->Graph.Start[vertex];
  const Index end = this->Graph.Start[vertex + 1];
  for (Index k = begin; k < end; ++k)
  {
    const Index leaf = this->Leaf[this->Graph.Neighbors[k]];
    if (this->Side(cut, this->Graph.Neighbors[k]) == 1 - side)
    {
      this->EdgesTo[leaf] += this->Graph.EdgeWeights[k];
      nearest = nearest < 0 || this->EdgesTo[leaf] > this->EdgesTo[nearest] ? leaf : nearest;
    }
  }
  for (Index k = begin; k < end; ++k)
  {
    this->EdgesTo[this->Leaf[this->Graph.Neighbors[k]]] = 0;
  }
  return nearest;
}

void GraphPartition::MoveAcross(const Cut& cut, Index vertex, Index leaf)
{
  const int from = this->Side(cut, vertex);
  this->Moves.emplace_back(vertex, this->Leaf[vertex]);
  this->Stamps[vertex] = 2 * this->Round + 1;
  this->Assign(vertex, leaf, cut.Node);
  for (Index k = this->Graph.Start[vertex]; k < this->Graph.Start[vertex + 1]; ++k)
  {
    const Index u = this->Graph.Neighbors[k];
    const int side = this->Side(cut, u);
    if (side < 0 || this->Stamps[u] == 2 * this->Round + 1)
    {
      continue;
    }
    if (this->Stamps[u] == 2 * this->Round)
    {
      this->Gains[u] += side == from ? 2 * this->Graph.EdgeWeights[k] : -2 * this->Graph.EdgeWeights[k];
    }
    else
    {
      this->Stamps[u] = 2 * this->Round;
      this->Gains[u] = this->Gain(cut, u);
    }
    this->Push(u);
  }
}

void GraphPartition::Undo(const Cut& cut, std::size_t kept)
{
  for (std::size_t k = this->Moves.size(); k-- > kept;)
  {
    this->Assign(this->Moves[k].first, this->Moves[k].second, cut.Node);
  }
}

bool GraphPartition::RefineOnce(const Cut& cut, std::vector<Index>& ends)
{
  const std::int64_t first = this->Weight[this->Child(cut, 0)];
  const std::int64_t second = this->Weight[this->Child(cut, 1)];
  const auto share = static_cast<std::int64_t>(SmallestShare * static_cast<double>(first + second));
  const std::int64_t least = std::min({ share, first, second });
  ++this->Round;
  this->Heap.clear();
  this->Moves.clear();
  for (const Index v : ends)
  {
    this->Stamps[v] = 2 * this->Round;
    this->Gains[v] = this->Gain(cut, v);
    this->Heap.emplace_back(this->Gains[v], v);
  }
  std::make_heap(this->Heap.begin(), this->Heap.end());

  std::int64_t saved = 0;
  std::int64_t most = 0;
  std::size_t kept = 0;
  const std::size_t patience = Patience + ends.size() / 4;
  while (this->Moves.size() < kept + patience)
  {
    const Index v = this->Pop();
    if (v < 0)
    {
      break;
    }
    const std::int64_t left = this->Weight[this->Child(cut, this->Side(cut, v))] - this->Graph.Weights[v];
    const Index leaf = left >= least ? this->NearestLeafAcross(cut, v) : -1;
    if (leaf < 0)
    {
      continue;
    }
    saved += this->Gains[v];
    this->MoveAcross(cut, v, leaf);
    if (saved > most)
    {
      most = saved;
      kept = this->Moves.size();
    }
  }
  this->Undo(cut, kept);

  for (std::size_t k = 0; k < kept; ++k)
  {
    const Index v = this->Moves[k].first;
    ends.push_back(v);
    ends.insert(ends.end(), this->Graph.Neighbors.begin() + this->Graph.Start[v],
      this->Graph.Neighbors.begin() + this->Graph.Start[v + 1]);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const auto isElsewhere = [&](Index v) { return !this->IsAtCut(cut, v); };
  ends.erase(std::remove_if(ends.begin(), ends.end(), isElsewhere), ends.end());
  return most > 0;
}

void GraphPartition::Refine(const Cut& cut, std::vector<Index>& ends)
{
  for (int round = 0; round < MostRounds && this->RefineOnce(cut, ends); ++round)
  {}
}

void GraphPartition::RefineCuts()
{
  // Vertices with an edge to another leaf, by the depth at which the tree parts the two. Those of a depth are collected
  // when their turn comes, since cuts above move them.
  std::vector<Index> ends;
  const int deepest = *std::max_element(this->Tree.Depth.begin(), this->Tree.Depth.end());
  std::vector<std::pair<Index, Index>> endsOfCuts;
  for (int depth = 0; depth < deepest; ++depth)
  {
    endsOfCuts.clear();
    for (Index v = 0; v < this->Graph.Size(); ++v)
    {
      const std::uint64_t path = this->Tree.Path[this->Leaf[v]];
      const auto isAcross = [&](Index u) { return (this->Tree.Path[this->Leaf[u]] ^ path) >> (63 - depth) == 1; };
      if (std::any_of(this->Graph.Neighbors.begin() + this->Graph.Start[v],
            this->Graph.Neighbors.begin() + this->Graph.Start[v + 1], isAcross))
      {
        Index node = this->Leaf[v];
        while (this->Tree.Depth[node] > depth)
        {
          node = this->Tree.Parent[node];
        }
        endsOfCuts.emplace_back(node, v);
      }
    }
    std::sort(endsOfCuts.begin(), endsOfCuts.end());
    for (std::size_t k = 0; k < endsOfCuts.size();)
    {
      const Index node = endsOfCuts[k].first;
      ends.clear();
      for (; k < endsOfCuts.size() && endsOfCuts[k].first == node; ++k)
      {
        ends.push_back(endsOfCuts[k].second);
      }
      this->Refine(this->CutOf(node), ends);
    }
  }
}

void GraphPartition::Grow(const Cut& cut, const std::vector<Index>& vertices, Index seed)
{
  const Index left = this->Child(cut, 0);
  ++this->Round;
  this->Heap.clear();
  this->Moves.clear();
  for (const Index v : vertices)
  {
    this->Assign(v, this->Child(cut, 1), cut.Node);
    this->Stamps[v] = 2 * this->Round;
  }
  for (const Index v : vertices)
  {
    this->Gains[v] = this->Gain(cut, v);
  }
  this->Push(seed);
  std::size_t next = 0;
  // At least one vertex stays, also where it outweighs all others.
  while (2 * this->Weight[left] < this->Weight[cut.Node] && this->Moves.size() + 1 < vertices.size())
  {
    Index v = this->Pop();
    while (v < 0) // nothing is next to the first side: another component of the graph
    {
      v = this->Side(cut, vertices[next]) == 1 ? vertices[next] : -1;
      ++next;
    }
    this->MoveAcross(cut, v, left);
  }
}

Index GraphPartition::FarthestFrom(Index seed, Index node)
{
  ++this->Round;
  std::vector<Index> queue{ seed };
  this->Stamps[seed] = 2 * this->Round;
  for (std::size_t q = 0; q < queue.size(); ++q)
  {
    for (Index k = this->Graph.Start[queue[q]]; k < this->Graph.Start[queue[q] + 1]; ++k)
    {
      const Index u = this->Graph.Neighbors[k];
      if (this->Leaf[u] == node && this->Stamps[u] != 2 * this->Round)
      {
        this->Stamps[u] = 2 * this->Round;
        queue.push_back(u);
      }
    }
  }
  return queue.back();
}

void GraphPartition::SplitLeaf(Index node, const std::vector<Index>& vertices, int tries)
{
  std::vector<Index> seeds{ this->FarthestFrom(vertices.front(), node) };
  seeds.push_back(this->FarthestFrom(seeds.front(), node));
  for (int k = 2; k < tries; ++k)
  {
    seeds.push_back(vertices[vertices.size() * static_cast<std::size_t>(k - 1) / static_cast<std::size_t>(tries)]);
  }
  this->Tree.Split(node);
  this->Weight.resize(static_cast<std::size_t>(this->Tree.Size()), 0);
  this->EdgesTo.resize(static_cast<std::size_t>(this->Tree.Size()), 0);
  const Cut cut = this->CutOf(node);

  std::int64_t fewest = -1;
  std::vector<Index> best(vertices.size());
  std::vector<Index> ends;
  for (int k = 0; k < tries; ++k)
  {
    this->Grow(cut, vertices, seeds[static_cast<std::size_t>(k)]);
    ends.clear();
    std::copy_if(
      vertices.begin(), vertices.end(), std::back_inserter(ends), [&](Index v) { return this->IsAtCut(cut, v); });
    this->Refine(cut, ends);
    const std::int64_t edges = this->EdgesCut(cut, vertices);
    if (fewest < 0 || edges < fewest)
    {
      fewest = edges;
      std::transform(vertices.begin(), vertices.end(), best.begin(), [&](Index v) { return this->Leaf[v]; });
    }
  }
  for (std::size_t k = 0; k < vertices.size(); ++k)
  {
    this->Assign(vertices[k], best[k], node);
  }
}

void GraphPartition::SplitLeaves(int tries, const SmallLeaf& small)
{
  std::vector<std::vector<Index>> verticesOf(static_cast<std::size_t>(this->Tree.Size()));
  for (Index v = 0; v < this->Graph.Size(); ++v)
  {
    verticesOf[this->Leaf[v]].push_back(v);
  }
  for (Index node = 0; node < this->Tree.Size(); ++node)
  {
    const std::vector<Index> vertices = std::move(verticesOf[node]);
    if (static_cast<Index>(vertices.size()) <= small.Vertices || this->Weight[node] <= small.Weight ||
      this->Tree.Depth[node] >= DissectionTree::MaximumDepth)
    {
      continue;
    }
    this->SplitLeaf(node, vertices, tries);
    verticesOf.resize(static_cast<std::size_t>(this->Tree.Size()));
    for (const Index v : vertices)
    {
      verticesOf[this->Leaf[v]].push_back(v);
    }
  }
}

} // namespace surfsynth
