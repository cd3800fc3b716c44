// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Quotient graphs of partial eliminations. Private to the solvers.
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The quotient graph of a partial elimination [Amestoy1996]: variables, each for one vertex or several that have become
/// alike, and elements, the cliques that eliminated variables left behind. A vertex is a variable, then an element or part
/// of one.
class QuotientGraph
{
public:
  /// Begins with the graph in which the neighbors of vertex v are neighbors[start[v]] .. neighbors[start[v + 1]); each edge
  /// at both ends, none from a vertex to itself.
  QuotientGraph(const std::vector<Index>& start, std::vector<Index> neighbors);

  /// Eliminates the variables of at most @p mostDegree, the least first, in one window of @p width numbers, at least 1, after
  /// the other.
  void Sweep(Index width, Index mostDegree);

  /// The vertices in a postorder of the tree in which an element is the parent of those that it absorbed. Call it when all are
  /// eliminated.
  std::vector<Index> Order() const;

private:
  struct Members;
  /// State of a vertex that is no variable. Variables list elements, then variables; elements list variables.
  enum State : Index
  {
    Element = -1, ///< Node::Elements of elements
    Absorbed = -2 ///< ... of vertices that are part of others
  };
  struct Node
  {
    Index Start;    ///< of the list, in Items
    Index Length;   ///< of the list
    Index Elements; ///< elements at the start of a variable's list, or a State
    Index Weight;   ///< vertices in a variable; negative in the clique at hand, 0 for anything else
  };
  /// Lists of variables of equal degree, and of equal hash.
  struct Link
  {
    Index Degree = 0;
    Index Next = -1;
    Index Previous = -1;
    Index NextOfHash = -1;
  };

  bool InWindow(Index variable) const { return variable >= this->Begin && variable < this->End; }
  void Insert(Index variable);
  void Remove(Index variable);
  void EnterWindow();
  void LeaveWindow();
  void CollectLists();
  void Eliminate(Index pivot);
  Index GatherClique(Index pivot);
  void Gather(Index first, Index last, Index& degree);
  void MarkElements(Index pivot);
  Index Prune(Index pivot);
  bool PruneList(Index variable, Index pivot);
  void MergeAlike();
  void MergeBucket(Index first);
  void Release(Index pivot, Index degree);
  void Absorb(Index vertex, Index into)
  {
    this->Nodes[vertex].Elements = Absorbed;
    this->Nodes[vertex].Length = 0;
    this->Parents[vertex] = into;
  }

  Index Size;
  std::vector<Index> Items; ///< lists: of the graph, then of elements that outgrew their vertices' own
  std::size_t MostItems;    ///< from which on lists are collected
  std::size_t Original;     ///< length of the first part of Items
  std::vector<Node> Nodes;
  std::vector<Link> Links;
  std::vector<Index> Heads;        ///< [n + 1], first variable of the window of each degree
  std::vector<Index> Buckets;      ///< [n + 1], first variable of the clique of each hash
  std::vector<Index> Used;         ///< buckets in use
  std::vector<std::int64_t> Marks; ///< of elements: weight outside the clique, plus Tag
  std::vector<Index> Parents;      ///< [n], what absorbed each vertex
  std::vector<Index> Pivots;
  std::vector<Index> Created; ///< elements of the window in the second part of Items
  std::int64_t Tag = 1;
  Index Largest = 0; ///< weight of an element
  Index Remaining;   ///< vertices that are not eliminated
  Index Begin = 0;
  Index End = 0;
  Index Least = 0;
};

} // namespace surfsynth
