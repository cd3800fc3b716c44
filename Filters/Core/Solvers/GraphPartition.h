// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Recursive bisections of graphs. Private to the solvers.
#pragma once

#include "Core/Solvers/GraphCoarsening.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace surfsynth
{

/// Binary tree of the parts of a graph: each part is cut into two, down to the leaves. Parents precede children.
struct DissectionTree
{
  std::vector<Index> Parent{ -1 };      ///< of each node, -1 at the root
  std::vector<Index> Left{ -1 };        ///< first child, -1 at a leaf; the second one is the next node
  std::vector<int> Depth{ 0 };          ///< steps from the root, at most MaximumDepth
  std::vector<std::uint64_t> Path{ 0 }; ///< the sides from the root on, the highest bit first, zeros behind the last

  static constexpr int MaximumDepth = 60;

  /// Number of nodes.
  Index Size() const { return static_cast<Index>(this->Parent.size()); }
  /// Whether @p node has no children.
  bool IsLeaf(Index node) const { return this->Left[node] < 0; }
  /// Gives the leaf @p node two children.
  void Split(Index node);
};

/// The parts of a graph that are the leaves of a tree, changed by the method of Fiduccia and Mattheyses [Fiduccia1982]:
/// the vertex whose move to the other side of a cut saves most edges moves, also at a loss, and the best of all states
/// that were passed is kept. Deterministic.
class GraphPartition
{
public:
  /// @param leaf [V], a leaf of the tree for each vertex; changed by the members
  GraphPartition(const WeightedGraph& graph, DissectionTree& tree, std::vector<Index>& leaf);

  /// Leaves that are not split.
  struct SmallLeaf
  {
    Index Vertices = 24;       ///< largest number of vertices, or ...
    std::int64_t Weight = 160; ///< ... largest number of vertices of the finest graph
  };
  /// Cuts leaves in two until all are small, each time at the best of @p tries cuts.
  void SplitLeaves(int tries, const SmallLeaf& small);
  /// Moves the cut of each inner node, the root first. Vertices that cross a cut join a leaf next to them.
  void RefineCuts();

private:
  /// The cut of a node: the children of the node are its sides.
  struct Cut
  {
    Index Node;
    int Depth;
    std::uint64_t Path;
  };
  Cut CutOf(Index node) const { return { node, this->Tree.Depth[node], this->Tree.Path[node] }; }
  /// 0 or 1: the child of the node in which @p vertex lies; -1: outside.
  int Side(const Cut& cut, Index vertex) const;
  Index Child(const Cut& cut, int side) const { return this->Tree.Left[cut.Node] + side; }
  void SplitLeaf(Index node, const std::vector<Index>& vertices, int tries);
  /// Moves vertices from the second to the first child, one next to the other from @p seed on, until the first one weighs
  /// half or more, or a single vertex is left.
  void Grow(const Cut& cut, const std::vector<Index>& vertices, Index seed);
  Index FarthestFrom(Index seed, Index node);
  void Refine(const Cut& cut, std::vector<Index>& ends);
  /// One round of moves from the vertices @p ends at the cut on, which it replaces. Returns whether edges were saved.
  bool RefineOnce(const Cut& cut, std::vector<Index>& ends);
  void MoveAcross(const Cut& cut, Index vertex, Index leaf);
  void Undo(const Cut& cut, std::size_t kept);
  /// Leaf on the other side to which @p vertex has most edges, -1 where it has none.
  Index NearestLeafAcross(const Cut& cut, Index vertex);
  /// Edges that a move of @p vertex across the cut saves.
  Index Gain(const Cut& cut, Index vertex) const;
  bool IsAtCut(const Cut& cut, Index vertex) const;
  std::int64_t EdgesCut(const Cut& cut, const std::vector<Index>& vertices) const;
  void Assign(Index vertex, Index leaf, Index top);
  void Push(Index vertex);
  Index Pop();

  const WeightedGraph& Graph;
  DissectionTree& Tree;
  std::vector<Index>& Leaf;
  std::vector<std::int64_t> Weight; ///< of each node of the tree
  std::vector<Index> Gains;         ///< [V], valid where Stamps says so
  std::vector<std::int64_t> Stamps; ///< [V], 2 Round: has a gain; 2 Round + 1: has moved
  std::int64_t Round = 0;
  std::vector<std::pair<Index, Index>> Heap;  ///< gains and vertices; those that are out of date are skipped
  std::vector<std::pair<Index, Index>> Moves; ///< vertices and the leaves that they left
  std::vector<Index> EdgesTo;                 ///< of each node of the tree, zero between uses
};

} // namespace surfsynth
