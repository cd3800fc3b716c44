// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/WindowedMinimumDegree.h"

#include "Core/Solvers/QuotientGraph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
} // namespace

std::vector<Index> WindowedMinimumDegreeOrder(const SparseMatrix& matrix, const std::vector<DegreeWindow>& windows)
{
  NumberedGraph numbered = BreadthFirst(matrix).Number();
  QuotientGraph graph(numbered.Start, std::move(numbered.Neighbors));
  for (const DegreeWindow& window : windows)
  {
    graph.Sweep(window.Width, window.MostDegree);
  }
  const auto size = static_cast<Index>(matrix.rows());
  graph.Sweep(size, size);
  std::vector<Index> order = graph.Order();
  std::transform(order.begin(), order.end(), order.begin(), [&](Index v) { return numbered.OldOfNew[v]; });
  order.insert(order.end(), numbered.Dense.begin(), numbered.Dense.end());
  return order;
}

} // namespace surfsynth
