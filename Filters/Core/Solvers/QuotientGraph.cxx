// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/QuotientGraph.h"

#include <algorithm>
#include <utility>

namespace surfsynth
{

QuotientGraph::QuotientGraph(const std::vector<Index>& start, std::vector<Index> neighbors)
  : Size(static_cast<Index>(start.size()) - 1)
  , Items(std::move(neighbors))
  , MostItems(2 * Items.size() + start.size())
  , Original(Items.size())
  , Nodes(start.size() - 1)
  , Links(Nodes.size())
  , Heads(Nodes.size() + 1, -1)
  , Buckets(Nodes.size() + 1, -1)
  , Marks(Nodes.size(), 0)
  , Parents(Nodes.size(), -1)
  , Remaining(Size)
{
  for (Index v = 0; v < this->Size; ++v)
  {
    this->Nodes[v] = { start[v], start[v + 1] - start[v], 0, 1 };
    this->Links[v].Degree = this->Nodes[v].Length;
  }
  this->Pivots.reserve(this->Nodes.size());
}

void QuotientGraph::Sweep(Index width, Index mostDegree)
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
    const auto isGone = [&](Index v) { return this->Nodes[v].Weight <= 0; };
    const auto last = std::remove_if(first, first + node.Length, isGone);
    node.Start = static_cast<Index>(end - this->Items.begin());
    node.Length = static_cast<Index>(last - first);
    end = end == first ? last : std::move(first, last, end);
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
  const Index more = this->Prune(pivot);
  this->Largest = std::max(this->Largest, degree);
  this->Tag += this->Largest + 1; // beyond all marks
  degree -= more;
  this->Links[pivot].Degree = degree;
  this->MergeAlike();
  this->Remaining -= weight + more;
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

/// Gives the variables of the clique their degrees, and drops merged and eliminated ones.
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
    bound = std::max(std::min(bound + degree, this->Remaining) - node.Weight, 0);
    if (this->InWindow(variable))
    {
      this->Insert(variable);
    }
    *end++ = variable;
  }
  clique.Length = static_cast<Index>(end - list);
}

/// Lists of the children of pivots, and of the vertices that were absorbed before they were pivots, whose turn is after their
/// pivot's.
struct QuotientGraph::Members
{
  explicit Members(const QuotientGraph& graph)
    : Child(graph.Nodes.size(), -1)
    , Sibling(graph.Nodes.size(), -1)
    , Member(graph.Nodes.size(), -1)
  {
    std::vector<bool> isPivot(graph.Nodes.size(), false);
    for (auto pivot = graph.Pivots.rbegin(); pivot != graph.Pivots.rend(); ++pivot)
    {
      isPivot[*pivot] = true;
      const Index parent = graph.Parents[*pivot];
      if (parent >= 0)
      {
        this->Sibling[*pivot] = this->Child[parent];
        this->Child[parent] = *pivot;
      }
    }
    for (Index v = graph.Size; v-- > 0;)
    {
      Index pivot = v;
      while (!isPivot[pivot])
      {
        pivot = graph.Parents[pivot];
      }
      if (pivot != v)
      {
        this->Sibling[v] = this->Member[pivot];
        this->Member[pivot] = v;
      }
    }
  }

  std::vector<Index> Child;   ///< [n], first one of a pivot
  std::vector<Index> Sibling; ///< [n], next child or member
  std::vector<Index> Member;  ///< [n], first one of a pivot
};

std::vector<Index> QuotientGraph::Order() const
{
  Members tree(*this);
  std::vector<Index> order;
  order.reserve(this->Nodes.size());
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
      Index& child = tree.Child[pivot];
      if (child >= 0)
      {
        stack.push_back(child);
        child = tree.Sibling[child];
        continue;
      }
      stack.pop_back();
      order.push_back(pivot);
      for (Index v = tree.Member[pivot]; v >= 0; v = tree.Sibling[v])
      {
        order.push_back(v);
      }
    }
  }
  return order;
}

} // namespace surfsynth
