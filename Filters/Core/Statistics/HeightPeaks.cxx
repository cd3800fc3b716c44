// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/HeightPeaks.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace surfsynth
{

namespace
{
/// The components of superlevel sets while vertices are added from the highest to the lowest.
class SuperlevelSets
{
public:
  SuperlevelSets(const MeshTopology& topology, const Eigen::VectorXd& heights)
    : Topology(topology)
    , Heights(heights)
    , Prominences(Eigen::VectorXd::Zero(heights.size()))
    , Heirs(static_cast<std::size_t>(heights.size()), -1)
    , Maxima(static_cast<std::size_t>(heights.size()), -1)
    , Roots(static_cast<std::size_t>(heights.size()), -1)
  {
    for (const Index v : this->DescendingVertices())
    {
      this->Add(v);
    }
    this->EndHighestMaxima();
  }

  /// True when @p a comes before @p b.
  bool IsHigher(Index a, Index b) const
  {
    return this->Heights[a] > this->Heights[b] || (this->Heights[a] == this->Heights[b] && a < b);
  }

  const MeshTopology& Topology;
  const Eigen::VectorXd& Heights;
  Eigen::VectorXd Prominences; ///< [V], of all maxima
  std::vector<Index> Heirs;    ///< [V], maximum whose region takes that of a maximum which is no peak; -1 for none
  std::vector<Index> Maxima;   ///< [V], maximum that the steepest edges lead to; -1 for unused vertices

private:
  std::vector<Index> DescendingVertices() const
  {
    std::vector<Index> order;
    for (Index v = 0; v < this->Topology.NumberOfPoints(); ++v)
    {
      if (this->Topology.NeighborStart[v] < this->Topology.NeighborStart[v + 1])
      {
        order.push_back(v);
      }
    }
    std::sort(order.begin(), order.end(), [this](Index a, Index b) { return this->IsHigher(a, b); });
    return order;
  }

  /// The highest vertex of the component of @p v, which was added. Halves the paths to it.
  Index RootOf(Index v)
  {
    while (this->Roots[v] != v)
    {
      this->Roots[v] = this->Roots[this->Roots[v]];
      v = this->Roots[v];
    }
    return v;
  }

  void Add(Index v)
  {
    const Index* begin = this->Topology.Neighbors.data() + this->Topology.NeighborStart[v];
    const Index* end = this->Topology.Neighbors.data() + this->Topology.NeighborStart[v + 1];
    Index highest = -1;
    for (const Index* w = begin; w != end; ++w)
    {
      if (this->Roots[*w] >= 0 && (highest < 0 || this->IsHigher(*w, highest)))
      {
        highest = *w;
      }
    }
    this->Roots[v] = highest < 0 ? v : this->RootOf(highest);
    this->Maxima[v] = highest < 0 ? v : this->Maxima[highest];
    for (const Index* w = begin; w != end; ++w)
    {
      if (*w != v && this->Roots[*w] >= 0)
      {
        this->Join(v, *w);
      }
    }
  }

  /// Joins the components of @p v, the lowest vertex so far, and its neighbor @p w.
  void Join(Index v, Index w)
  {
    Index elder = this->RootOf(v), younger = this->RootOf(w);
    Index acrossTheSaddle = this->Maxima[v];
    if (elder == younger)
    {
      return;
    }
    if (this->IsHigher(younger, elder))
    {
      std::swap(elder, younger);
      acrossTheSaddle = this->Maxima[w];
    }
    this->Prominences[younger] = this->Heights[younger] - this->Heights[v];
    this->Heirs[younger] = acrossTheSaddle;
    this->Roots[younger] = elder;
  }

  /// The highest maximum of each component of the mesh ends at its lowest vertex.
  void EndHighestMaxima()
  {
    Eigen::VectorXd lowest = this->Heights;
    for (Index v = 0; v < this->Topology.NumberOfPoints(); ++v)
    {
      if (this->Roots[v] >= 0)
      {
        const Index root = this->RootOf(v);
        lowest[root] = std::min(lowest[root], this->Heights[v]);
      }
    }
    for (Index v = 0; v < this->Topology.NumberOfPoints(); ++v)
    {
      if (this->Roots[v] == v)
      {
        this->Prominences[v] = this->Heights[v] - lowest[v];
      }
    }
  }

  std::vector<Index> Roots; ///< [V], a vertex of the same component on the way to its highest one; -1 before v is added
};

/// Keeps the maxima with more than @p minimum prominence.
HeightPeaks KeepPeaks(const SuperlevelSets& sets, double minimum)
{
  HeightPeaks found;
  const Index count = sets.Topology.NumberOfPoints();
  found.Prominences = Eigen::VectorXd::Zero(count);
  std::vector<Index> number(static_cast<std::size_t>(count), -1);
  for (Index v = 0; v < count; ++v)
  {
    if (sets.Maxima[v] == v && sets.Prominences[v] > minimum)
    {
      number[v] = static_cast<Index>(found.Peaks.size());
      found.Peaks.push_back(v);
      found.Prominences[v] = sets.Prominences[v];
    }
  }
  // Heirs are maxima of components with a higher maximum, so that the way along them ends.
  std::vector<Index> settled(static_cast<std::size_t>(count), -1);
  found.Regions.assign(static_cast<std::size_t>(count), -1);
  for (Index v = 0; v < count; ++v)
  {
    Index maximum = sets.Maxima[v];
    if (maximum < 0)
    {
      continue;
    }
    if (settled[maximum] < 0)
    {
      Index peak = maximum;
      while (number[peak] < 0 && sets.Heirs[peak] >= 0)
      {
        peak = sets.Heirs[peak];
      }
      settled[maximum] = peak;
    }
    found.Regions[v] = number[settled[maximum]];
  }
  return found;
}

/// The highest saddle of each pair of neighboring regions, by ascending numbers of peaks.
std::map<std::pair<Index, Index>, double> SaddlesOf(const SuperlevelSets& sets, const std::vector<Index>& regions)
{
  std::map<std::pair<Index, Index>, double> saddles;
  for (Index v = 0; v < sets.Topology.NumberOfPoints(); ++v)
  {
    for (Index k = sets.Topology.NeighborStart[v]; k < sets.Topology.NeighborStart[v + 1]; ++k)
    {
      const Index w = sets.Topology.Neighbors[k];
      if (regions[v] < regions[w] && regions[v] >= 0)
      {
        const double height = std::min(sets.Heights[v], sets.Heights[w]);
        const auto place = saddles.try_emplace({ regions[v], regions[w] }, height).first;
        place->second = std::max(place->second, height);
      }
    }
  }
  return saddles;
}
} // namespace

HeightPeaks FindHeightPeaks(
  const MeshTopology& topology, const Eigen::VectorXd& heights, double minimumProminence, double base)
{
  const SuperlevelSets sets(topology, heights);
  HeightPeaks found = KeepPeaks(sets, minimumProminence);
  const auto count = static_cast<Eigen::Index>(found.Peaks.size());
  found.Saddles = Eigen::VectorXd::Constant(count, -std::numeric_limits<double>::infinity());
  found.SaddleRatios = Eigen::VectorXd::Zero(count);
  for (const auto& [pair, saddle] : SaddlesOf(sets, found.Regions))
  {
    const double lower = std::min(heights[found.Peaks[static_cast<std::size_t>(pair.first)]],
      heights[found.Peaks[static_cast<std::size_t>(pair.second)]]);
    const double ratio = lower > base ? (saddle - base) / (lower - base) : 0.0;
    for (const Index peak : { pair.first, pair.second })
    {
      found.Saddles[peak] = std::max(found.Saddles[peak], saddle);
      found.SaddleRatios[peak] = std::max(found.SaddleRatios[peak], ratio);
    }
  }
  return found;
}

} // namespace surfsynth
