// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/VertexCover.h"

#include <algorithm>
#include <numeric>

namespace surfsynth
{

namespace
{
/// A largest matching of a bipartite graph, by augmenting paths.
class BipartiteMatching
{
public:
  BipartiteMatching(Index left, Index right, const std::vector<std::pair<Index, Index>>& sortedEdges)
    : Start(static_cast<std::size_t>(left) + 1, 0)
    , MateOfLeft(static_cast<std::size_t>(left), -1)
    , MateOfRight(static_cast<std::size_t>(right), -1)
    , From(static_cast<std::size_t>(right), -1)
    , IsReached(static_cast<std::size_t>(right), false)
  {
    for (const auto& [a, b] : sortedEdges)
    {
      ++this->Start[a + 1];
      this->Neighbors.push_back(b);
    }
    std::partial_sum(this->Start.begin(), this->Start.end(), this->Start.begin());
    this->MatchGreedily();
    for (Index root = 0; root < left; ++root)
    {
      if (this->MateOfLeft[root] < 0)
      {
        this->Augment(root);
      }
    }
  }

  /// The left vertices that no alternating path from an unmatched one reaches, and the right ones that one reaches.
  VertexCover Cover()
  {
    const std::size_t left = this->MateOfLeft.size();
    const std::size_t right = this->MateOfRight.size();
    VertexCover cover{ std::vector<bool>(left, true), std::vector<bool>(right, false) };
    this->Queue.clear();
    for (std::size_t a = 0; a < left; ++a)
    {
      if (this->MateOfLeft[a] < 0)
      {
        cover.Left[a] = false;
        this->Queue.push_back(static_cast<Index>(a));
      }
    }
    for (std::size_t q = 0; q < this->Queue.size(); ++q)
    {
      for (Index k = this->Start[this->Queue[q]]; k < this->Start[this->Queue[q] + 1]; ++k)
      {
        const Index b = this->Neighbors[k];
        if (!cover.Right[b])
        {
          cover.Right[b] = true;
          cover.Left[this->MateOfRight[b]] = false;
          this->Queue.push_back(this->MateOfRight[b]);
        }
      }
    }
    return cover;
  }

private:
  void MatchGreedily()
  {
    for (std::size_t a = 0; a < this->MateOfLeft.size(); ++a)
    {
      const auto end = this->Neighbors.begin() + this->Start[a + 1];
      const auto found = std::find_if(
        this->Neighbors.begin() + this->Start[a], end, [&](Index b) { return this->MateOfRight[b] < 0; });
      if (found != end)
      {
        this->MateOfLeft[a] = *found;
        this->MateOfRight[*found] = static_cast<Index>(a);
      }
    }
  }

  /// Looks for an unmatched right vertex along alternating paths from @p root, breadth first, and swaps the path there.
  /// What a search without success has reached leads nowhere later either, and is not searched again.
  void Augment(Index root)
  {
    Index end = -1;
    this->Queue.assign(1, root);
    this->Visited.clear();
    for (std::size_t q = 0; q < this->Queue.size() && end < 0; ++q)
    {
      const Index a = this->Queue[q];
      for (Index k = this->Start[a]; k < this->Start[a + 1] && end < 0; ++k)
      {
        const Index b = this->Neighbors[k];
        if (this->IsReached[b])
        {
          continue;
        }
        this->IsReached[b] = true;
        this->Visited.push_back(b);
        this->From[b] = a;
        if (this->MateOfRight[b] < 0)
        {
          end = b;
        }
        else
        {
          this->Queue.push_back(this->MateOfRight[b]);
        }
      }
    }
    for (std::size_t k = 0; end >= 0 && k < this->Visited.size(); ++k)
    {
      this->IsReached[this->Visited[k]] = false;
    }
    while (end >= 0)
    {
      const Index a = this->From[end];
      this->MateOfRight[end] = a;
      end = std::exchange(this->MateOfLeft[a], end);
    }
  }

  std::vector<Index> Start;     ///< [L + 1], into Neighbors
  std::vector<Index> Neighbors; ///< right ends of the edges of each left vertex
  std::vector<Index> MateOfLeft;
  std::vector<Index> MateOfRight;
  std::vector<Index> From;     ///< [R], left vertex from which the search came
  std::vector<bool> IsReached; ///< [R], by this search or one without success
  std::vector<Index> Visited;  ///< right vertices that this search has reached
  std::vector<Index> Queue;
};
} // namespace

VertexCover MinimumVertexCover(Index left, Index right, std::vector<std::pair<Index, Index>>& edges)
{
  std::sort(edges.begin(), edges.end());
  return BipartiteMatching(left, right, edges).Cover();
}

} // namespace surfsynth
