// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/WindowedMinimumDegree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
/// Vertices of a graph in the order in which they are numbered anew, and their neighbors by the new numbers.
struct NumberedGraph
{
  std::vector<Index> OldOfNew; ///< [n], vertices that are not dense, breadth first
  std::vector<Index> Start;    ///< [n + 1], into Neighbors
  std::vector<Index> Neighbors;
  std::vector<Index> Dense; ///< vertices with too many neighbors, which have no edges here
};

/// Numbers the vertices of a matrix breadth first, from the first vertex of each component.
class BreadthFirst
{
public:
  explicit BreadthFirst(const SparseMatrix& matrix)
    : Start(matrix.outerIndexPtr())
    , Rows(matrix.innerIndexPtr())
    , Size(static_cast<Index>(matrix.rows()))
    , NewOfOld(static_cast<std::size_t>(Size), -1)
  {}

  NumberedGraph Number()
  {
    this->Result.OldOfNew.reserve(this->NewOfOld.size());
    const double most = std::max(16.0, 10.0 * std::sqrt(static_cast<double>(this->Size)));
    for (Index v = 0; v < this->Size; ++v)
    {
      if (this->Start[v + 1] - this->Start[v] > most)
      {
        this->Result.Dense.push_back(v);
        this->NewOfOld[v] = Dense;
      }
    }
    for (Index v = 0; v < this->Size; ++v)
    {
      this->VisitFrom(v);
    }
    this->Connect();
    return std::move(this->Result);
  }

private:
  static constexpr Index Dense = std::numeric_limits<Index>::max();

  void Visit(Index vertex)
  {
    if (this->NewOfOld[vertex] < 0)
    {
      this->NewOfOld[vertex] = static_cast<Index>(this->Result.OldOfNew.size());
      this->Result.OldOfNew.push_back(vertex);
    }
  }
  void VisitFrom(Index seed)
  {
    std::size_t next = this->Result.OldOfNew.size();
    this->Visit(seed);
    for (; next < this->Result.OldOfNew.size(); ++next)
    {
      const Index v = this->Result.OldOfNew[next];
      for (Index k = this->Start[v]; k < this->Start[v + 1]; ++k)
      {
        this->Visit(this->Rows[k]);
      }
    }
  }
  void Connect()
  {
    this->Result.Start.assign(1, 0);
    this->Result.Start.reserve(this->Result.OldOfNew.size() + 1);
    this->Result.Neighbors.reserve(static_cast<std::size_t>(this->Start[this->Size]));
    for (const Index v : this->Result.OldOfNew)
    {
      for (Index k = this->Start[v]; k < this->Start[v + 1]; ++k)
      {
        const Index neighbor = this->NewOfOld[this->Rows[k]];
        if (this->Rows[k] != v && neighbor != Dense)
        {
          this->Result.Neighbors.push_back(neighbor);
        }
      }
      this->Result.Start.push_back(static_cast<Index>(this->Result.Neighbors.size()));
    }
  }

  const Index* Start;
  const Index* Rows;
  Index Size;
  std::vector<Index> NewOfOld;
  NumberedGraph Result;
};

/// The quotient graph of a partial elimination [Amestoy1996]: variables, each for one vertex or several that have become
/// alike, and elements, the cliques that eliminated variables left behind. A vertex is a variable, then an element or part
/// of one.
class QuotientGraph
{
public:
  explicit QuotientGraph(NumberedGraph graph)
    : Size(static_cast<Index>(graph.OldOfNew.size()))
    , OldOfNew(std::move(graph.OldOfNew))
    , Items(std::move(graph.Neighbors))
    , MostItems(2 * Items.size() + OldOfNew.size())
    , Original(Items.size())
    , Nodes(OldOfNew.size())
    , Links(OldOfNew.size())
    , Heads(OldOfNew.size() + 1, -1)
    , Buckets(OldOfNew.size() + 1, -1)
    , Marks(OldOfNew.size(), 0)
    , Parents(OldOfNew.size(), -1)
    , Left(Size)
  {
    for (Index v = 0; v < this->Size; ++v)
    {
      this->Nodes[v] = { graph.Start[v], graph.Start[v + 1] - graph.Start[v], 0, 1 };
      this->Links[v].Degree = this->Nodes[v].Length;
    }
    this->Pivots.reserve(this->OldOfNew.size());
  }

  /// Eliminates the variables of at most @p mostDegree, the least first, in one window of @p width numbers after the other.
  void Sweep(Index width, Index mostDegree)
  {
    for (this->Begin = 0; this->Begin < this->Size; this->Begin = this->End)
    {
      this->End = this->Begin + std::min(width, this->Size - this->Begin);
      this->EnterWindow();
      while (this->Least <= std::min(mostDegree, this->Size - 1))
      {
        if (this->Heads[this->Least] < 0)
        {
          ++this->Least;
          continue;
        }
        this->Eliminate(this->Heads[this->Least]);
      }
      this->LeaveWindow();
    }
  }

  /// The vertices, old numbers, in a postorder of the elements' tree.
  std::vector<Index> Order() const;

private:
  /// What becomes of a vertex. Variables list elements, then variables; elements list variables.
  enum State : Index
  {
    Element = -1, ///< Node::Elements of elements
    Absorbed = -2 ///< ... of vertices that are part of others
  };
  struct Node
  {
    Index Start;    ///< of the list, in Items
    Index Length;   ///< of the list
    Index Elements; ///< elements at the begin of a variable's list, or a State
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
  std::vector<Index> OldOfNew;
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
  Index Left;
  Index Begin = 0;
  Index End = 0;
  Index Least = 0;
};

void QuotientGraph::Insert(Index variable)
{
  Link& link = this->Links[variable];
  link.Previous = -1;
  link.Next = this->Heads[link.Degree];
  if (link.Next >= 0)
  {
    this->Links[link.Next].Previous = variable;
  }
  this->Heads[link.Degree] = variable;
  this->Least = std::min(this->Least, link.Degree);
}

void QuotientGraph::Remove(Index variable)
{
  const Link& link = this->Links[variable];
  if (link.Next >= 0)
  {
    this->Links[link.Next].Previous = link.Previous;
  }
  (link.Previous >= 0 ? this->Links[link.Previous].Next : this->Heads[link.Degree]) = link.Next;
}

void QuotientGraph::EnterWindow()
{
  this->Least = this->Size; // none has so many neighbors
  for (Index v = this->Begin; v < this->End; ++v)
  {
    if (this->Nodes[v].Weight > 0)
    {
      this->Insert(v);
    }
  }
}

void QuotientGraph::LeaveWindow()
{
  for (Index v = this->Begin; v < this->End; ++v)
  {
    if (this->Nodes[v].Weight > 0)
    {
      this->Heads[this->Links[v].Degree] = -1;
    }
  }
  this->CollectLists();
  this->Created.clear();
  this->Original = this->Items.size();
}

/// Moves the lists of the window's elements to where those of absorbed ones were.
void QuotientGraph::CollectLists()
{
  auto end = this->Items.begin() + static_cast<std::ptrdiff_t>(this->Original);
  const auto isAbsorbed = [&](Index element) { return this->Nodes[element].Elements != Element; };
  this->Created.erase(std::remove_if(this->Created.begin(), this->Created.end(), isAbsorbed), this->Created.end());
  for (const Index element : this->Created)
  {
    Node& node = this->Nodes[element];
    const auto first = this->Items.begin() + node.Start;
    node.Start = static_cast<Index>(end - this->Items.begin());
    end = std::copy_if(first, first + node.Length, end, [&](Index v) { return this->Nodes[v].Weight > 0; });
    node.Length = static_cast<Index>(end - this->Items.begin()) - node.Start;
  }
  this->Items.erase(end, this->Items.end());
  this->MostItems = 2 * this->Items.size() + this->Nodes.size();
}

void QuotientGraph::Eliminate(Index pivot)
{
  if (this->Items.size() > this->MostItems)
  {
    this->CollectLists();
  }
  this->Remove(pivot);
  this->Pivots.push_back(pivot);
  const Index weight = this->Nodes[pivot].Weight;
  Index degree = this->GatherClique(pivot);
  this->MarkElements(pivot);
  this->Links[pivot].Degree = degree;
  const Index more = this->Prune(pivot);
  this->Largest = std::max(this->Largest, degree);
  this->Tag += this->Largest + 1; // beyond all marks
  degree -= more;
  this->Links[pivot].Degree = degree;
  this->MergeAlike();
  this->Left -= weight + more;
  this->Release(pivot, degree);
}

/// Adds the variables Items[first] .. Items[last) that are not in the clique yet to it, at the end of Items.
void QuotientGraph::Gather(Index first, Index last, Index& degree)
{
  for (Index k = first; k < last; ++k)
  {
    const Index v = this->Items[k];
    Node& node = this->Nodes[v];
    if (node.Weight > 0)
    {
      degree += node.Weight;
      node.Weight = -node.Weight;
      this->Items.push_back(v);
      if (this->InWindow(v))
      {
        this->Remove(v);
      }
    }
  }
}

/// Turns the pivot into an element, with the variables of its list and of its elements, which it absorbs.
/// @return their weight
Index QuotientGraph::GatherClique(Index pivot)
{
  const Node old = this->Nodes[pivot];
  this->Nodes[pivot].Weight = 0;
  Index degree = 0;
  const auto begin = static_cast<Index>(this->Items.size());
  for (Index k = old.Start; k < old.Start + old.Elements; ++k)
  {
    const Index element = this->Items[k];
    const Node& node = this->Nodes[element];
    this->Gather(node.Start, node.Start + node.Length, degree);
    this->Absorb(element, pivot);
  }
  this->Gather(old.Start + old.Elements, old.Start + old.Length, degree);
  Node& node = this->Nodes[pivot];
  node.Elements = Element;
  node.Length = static_cast<Index>(this->Items.size()) - begin;
  node.Start = begin;
  if (old.Elements == 0) // the list is no longer than it was
  {
    std::copy(this->Items.begin() + begin, this->Items.end(), this->Items.begin() + old.Start);
    this->Items.resize(static_cast<std::size_t>(begin));
    node.Start = old.Start;
  }
  else
  {
    this->Created.push_back(pivot);
  }
  return degree;
}

/// Subtracts the weight of the clique from that of each element that shares variables with it.
void QuotientGraph::MarkElements(Index pivot)
{
  const Node clique = this->Nodes[pivot];
  for (Index k = clique.Start; k < clique.Start + clique.Length; ++k)
  {
    const Node variable = this->Nodes[this->Items[k]];
    for (Index e = variable.Start; e < variable.Start + variable.Elements; ++e)
    {
      const Index element = this->Items[e];
      std::int64_t& mark = this->Marks[element];
      if (this->Nodes[element].Elements == Element)
      {
        mark = (mark >= this->Tag ? mark : this->Links[element].Degree + this->Tag) + variable.Weight;
      }
    }
  }
}

/// Drops from the list of a variable what the new element stands for, enters the element, and finds degree outside of the
/// clique and hash.
/// @return whether anything but the new element is left
bool QuotientGraph::PruneList(Index variable, Index pivot)
{
  Node& node = this->Nodes[variable];
  Index* const list = this->Items.data() + node.Start;
  Index* end = list;
  Index degree = 0;
  auto hash = static_cast<std::uint32_t>(pivot);
  for (Index k = 0; k < node.Elements; ++k)
  {
    const Index element = list[k];
    if (this->Nodes[element].Elements != Element)
    {
      continue;
    }
    const auto outside = static_cast<Index>(this->Marks[element] - this->Tag);
    if (outside == 0)
    {
      this->Absorb(element, pivot);
      continue;
    }
    degree += outside;
    hash += static_cast<std::uint32_t>(element);
    *end++ = element;
  }
  Index* const variables = end;
  for (Index k = node.Elements; k < node.Length; ++k)
  {
    const Index other = list[k];
    const Index weight = this->Nodes[other].Weight;
    if (weight > 0)
    {
      degree += weight;
      hash += static_cast<std::uint32_t>(other);
      *end++ = other;
    }
  }
  if (end == list)
  {
    return false;
  }
  *end = *variables; // the pivot was in the list, or an element that it absorbed: there is room
  *variables = pivot;
  node.Elements = static_cast<Index>(variables - list) + 1;
  node.Length = static_cast<Index>(end - list) + 1;
  Link& link = this->Links[variable];
  link.Degree = std::min(link.Degree, degree);
  const auto bucket = static_cast<Index>(hash % static_cast<std::uint32_t>(this->Size));
  if (this->Buckets[bucket] < 0)
  {
    this->Used.push_back(bucket);
  }
  link.NextOfHash = this->Buckets[bucket];
  this->Buckets[bucket] = variable;
  return true;
}

/// Prunes the lists of the clique's variables. Those that have no other neighbors are eliminated with the pivot.
/// @return the weight of the latter
Index QuotientGraph::Prune(Index pivot)
{
  Index eliminated = 0;
  const Node clique = this->Nodes[pivot];
  for (Index k = clique.Start; k < clique.Start + clique.Length; ++k)
  {
    const Index variable = this->Items[k];
    if (!this->PruneList(variable, pivot))
    {
      eliminated -= this->Nodes[variable].Weight;
      this->Nodes[variable].Weight = 0;
      this->Absorb(variable, pivot);
    }
  }
  return eliminated;
}

/// Joins variables of the clique that have the same neighbors.
void QuotientGraph::MergeAlike()
{
  for (const Index bucket : this->Used)
  {
    const Index first = this->Buckets[bucket];
    this->Buckets[bucket] = -1;
    this->MergeBucket(first);
  }
  this->Used.clear();
}

void QuotientGraph::MergeBucket(Index first)
{
  for (Index i = first; i >= 0 && this->Links[i].NextOfHash >= 0; i = this->Links[i].NextOfHash)
  {
    ++this->Tag;
    Node& node = this->Nodes[i];
    const Index* list = this->Items.data() + node.Start;
    std::for_each(list, list + node.Length, [&](Index item) { this->Marks[item] = this->Tag; });
    Index before = i;
    for (Index j = this->Links[i].NextOfHash; j >= 0; j = this->Links[before].NextOfHash)
    {
      Node& other = this->Nodes[j];
      const Index* items = this->Items.data() + other.Start;
      const bool alike = other.Length == node.Length && other.Elements == node.Elements &&
        std::all_of(items, items + other.Length, [&](Index item) { return this->Marks[item] == this->Tag; });
      if (!alike)
      {
        before = j;
        continue;
      }
      node.Weight += other.Weight;
      other.Weight = 0;
      this->Absorb(j, i);
      this->Links[before].NextOfHash = this->Links[j].NextOfHash;
    }
  }
  ++this->Tag;
}

/// Gives the variables of the clique their degrees, and drops those that are no more.
void QuotientGraph::Release(Index pivot, Index degree)
{
  Node& clique = this->Nodes[pivot];
  Index* const list = this->Items.data() + clique.Start;
  Index* end = list;
  for (Index k = 0; k < clique.Length; ++k)
  {
    const Index variable = list[k];
    Node& node = this->Nodes[variable];
    if (node.Weight == 0)
    {
      continue;
    }
    node.Weight = -node.Weight;
    Index& bound = this->Links[variable].Degree;
    bound = std::max(std::min(bound + degree, this->Left) - node.Weight, 0);
    if (this->InWindow(variable))
    {
      this->Insert(variable);
    }
    *end++ = variable;
  }
  clique.Length = static_cast<Index>(end - list);
}

std::vector<Index> QuotientGraph::Order() const
{
  // Lists of children, and of the vertices that were absorbed before they were pivots, whose turn is after their pivot's.
  std::vector<bool> isPivot(this->OldOfNew.size(), false);
  std::vector<Index> child(this->OldOfNew.size(), -1);
  std::vector<Index> sibling(this->OldOfNew.size(), -1);
  std::vector<Index> member(this->OldOfNew.size(), -1);
  for (auto pivot = this->Pivots.rbegin(); pivot != this->Pivots.rend(); ++pivot)
  {
    isPivot[*pivot] = true;
    const Index parent = this->Parents[*pivot];
    if (parent >= 0)
    {
      sibling[*pivot] = child[parent];
      child[parent] = *pivot;
    }
  }
  for (Index v = this->Size; v-- > 0;)
  {
    if (!isPivot[v])
    {
      Index pivot = this->Parents[v];
      while (!isPivot[pivot])
      {
        pivot = this->Parents[pivot];
      }
      sibling[v] = member[pivot];
      member[pivot] = v;
    }
  }
  std::vector<Index> order;
  order.reserve(this->OldOfNew.size());
  std::vector<Index> stack;
  for (const Index root : this->Pivots)
  {
    if (this->Parents[root] < 0)
    {
      stack.push_back(root);
    }
    while (!stack.empty())
    {
      const Index pivot = stack.back();
      if (child[pivot] >= 0)
      {
        stack.push_back(child[pivot]);
        child[pivot] = sibling[child[pivot]];
        continue;
      }
      stack.pop_back();
      order.push_back(this->OldOfNew[pivot]);
      for (Index v = member[pivot]; v >= 0; v = sibling[v])
      {
        order.push_back(this->OldOfNew[v]);
      }
    }
  }
  return order;
}
} // namespace

std::vector<Index> WindowedMinimumDegreeOrder(const SparseMatrix& matrix)
{
  // Windows whose lists fit the cache of a core; degrees from which on less than a half and a quarter of the vertices are left.
  constexpr Index NarrowWindow = 16384;
  constexpr Index LowDegree = 10;
  constexpr Index WideWindow = 131072;
  constexpr Index MediumDegree = 24;
  NumberedGraph numbered = BreadthFirst(matrix).Number();
  const std::vector<Index> dense = std::move(numbered.Dense);
  QuotientGraph graph(std::move(numbered));
  graph.Sweep(NarrowWindow, LowDegree);
  graph.Sweep(WideWindow, MediumDegree);
  const auto size = static_cast<Index>(matrix.rows());
  graph.Sweep(size, size);
  std::vector<Index> order = graph.Order();
  order.insert(order.end(), dense.begin(), dense.end());
  return order;
}

} // namespace surfsynth
