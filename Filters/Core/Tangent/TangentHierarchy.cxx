// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/TangentHierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace surfsynth
{

namespace
{
using Complex = std::complex<double>;

/// Edge of a level: a source seen from a vertex.
struct LevelEdge
{
  Index Source;
  double Length;     ///< of the path, world units
  Complex Logarithm; ///< world units
  Complex Transport; ///< to the vertex
};

bool IsShorter(const LevelEdge& a, const LevelEdge& b)
{
  return std::tie(a.Source, a.Length) < std::tie(b.Source, b.Length);
}

/// Edges of vertex v of the surface. Of OneRings, the transport is that from v to the neighbor.
template <typename Use>
void ForEdges(const OneRings& rings, Index v, const Use& use)
{
  for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
  {
    const Complex logarithm = rings.NeighborLogarithms[k];
    use(LevelEdge{ rings.Neighbors[k], std::abs(logarithm), logarithm, std::conj(rings.Transport[k]) });
  }
}

/// Appends the neighborhood of the next vertex.
void AppendVertex(const std::vector<LevelEdge>& edges, Index vertex, const std::vector<double>& areas, double radius,
  TangentNeighborhoods& out)
{
  double total = areas[vertex];
  for (const LevelEdge& edge : edges)
  {
    total += areas[edge.Source];
  }
  const auto append = [&](Index source, Complex logarithm, Complex transport) {
    out.Sources.push_back(source);
    out.Logarithms.emplace_back(logarithm / radius);
    out.Transport.emplace_back(transport);
    out.Weights.push_back(static_cast<float>(total > 0.0 ? areas[source] / total : 1.0));
  };
  append(vertex, 0.0, 1.0);
  for (const LevelEdge& edge : edges)
  {
    append(edge.Source, edge.Logarithm, edge.Transport);
  }
  out.Start.push_back(static_cast<Index>(out.Sources.size()));
}

/// Radius of the mean vertex area element; 1 without triangles.
double RadiusOf(const std::vector<double>& areas)
{
  const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
  const auto used = std::count_if(areas.begin(), areas.end(), [](double a) { return a > 0.0; });
  return used > 0 ? std::sqrt(area / (std::acos(-1.0) * static_cast<double>(used))) : 1.0;
}

/// Radius within which a vertex is at the centroid of its ring, over the radius of the mean vertex area element.
constexpr double CentroidRadius = 1e-3;

/// Thirds of the areas of the rings, which are the areas of the vertices.
std::vector<double> AreasOf(const OneRings& rings)
{
  std::vector<double> areas(static_cast<std::size_t>(rings.NumberOfPoints()));
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    areas[v] = rings.Areas[v] / 3.0;
  }
  return areas;
}

/// Centroid of a ring as seen from its vertex, world units; 0 without triangles.
Complex RingCentroid(const OneRings& rings, Index v)
{
  Complex sum = 0.0;
  double areas = 0.0;
  for (Index k = rings.RingStart[v]; k < rings.RingStart[v + 1]; ++k)
  {
    const RingCorner& corner = rings.Corners[rings.RingCorners[k]];
    const double area = corner.Length * corner.OtherY;
    sum += area * corner.Logarithm(1.0 / 3.0, 1.0 / 3.0);
    areas += area;
  }
  return areas > 0.0 ? sum / areas : 0.0;
}

/// Direction of the centroid of a ring, shortened where it is within @p least of the vertex.
Complex CentroidDirection(const OneRings& rings, Index v, double least)
{
  const Complex mean = RingCentroid(rings, v);
  return mean / std::sqrt(std::norm(mean) + least * least);
}

/// Maximal independent set; 1 for its members.
std::vector<std::uint8_t> ChooseCenters(const OneRings& rings)
{
  std::vector<Index> order(static_cast<std::size_t>(rings.NumberOfPoints()));
  std::iota(order.begin(), order.end(), 0);
  const double scale = rings.Areas.size() > 0 && rings.Areas.maxCoeff() > 0.0 ? 1.0 / rings.Areas.maxCoeff() : 1.0;
  const auto key = [&](Index v) {
    return std::make_tuple(-static_cast<float>(rings.Areas[v] * scale), -static_cast<float>(rings.TotalAngles[v]),
      rings.NeighborStart[v] - rings.NeighborStart[v + 1], v);
  };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
  std::vector<std::uint8_t> chosen(order.size(), 0);
  std::vector<std::uint8_t> covered(order.size(), 0);
  for (const Index v : order)
  {
    if (!covered[v])
    {
      chosen[v] = 1;
      ForEdges(rings, v, [&](const LevelEdge& edge) { covered[edge.Source] = 1; });
    }
  }
  return chosen;
}

/// Step from a vertex to the center of its cluster, as an edge seen from the vertex.
LevelEdge StepToCenter(const OneRings& rings, const std::vector<std::uint8_t>& chosen, Index v)
{
  LevelEdge best = { v, 0.0, 0.0, 1.0 };
  if (chosen[v])
  {
    return best;
  }
  best.Length = -1.0;
  ForEdges(rings, v, [&](const LevelEdge& edge) {
    if (chosen[edge.Source] && (best.Length < 0.0 || edge.Length < best.Length))
    {
      best = edge;
    }
  });
  return best;
}

/// Path from center a by u and v to center b: @p fromU and @p fromV are the steps of u and v to their centers, @p edge
/// is v as seen from u.
LevelEdge Join(const LevelEdge& fromU, const LevelEdge& edge, const LevelEdge& fromV, Index coarse)
{
  const Complex toA = std::conj(fromU.Transport); // fromU.Transport carries vectors of the center to u
  return { coarse, fromU.Length + edge.Length + fromV.Length,
    -toA * fromU.Logarithm + toA * (edge.Logarithm + edge.Transport * fromV.Logarithm),
    toA * edge.Transport * fromV.Transport };
}
/// Shortest paths from cluster @p a to those that touch it.
std::vector<LevelEdge> ClusterEdges(const OneRings& rings, const std::vector<Index>& clusters,
  const std::vector<LevelEdge>& steps, const std::vector<Index>& members, Index a)
{
  std::vector<LevelEdge> edges;
  for (const Index u : members)
  {
    ForEdges(rings, u, [&](const LevelEdge& edge) {
      const Index b = clusters[edge.Source];
      if (b != a)
      {
        edges.push_back(Join(steps[u], edge, steps[edge.Source], b));
      }
    });
  }
  std::stable_sort(edges.begin(), edges.end(), IsShorter);
  const auto same = [](const LevelEdge& x, const LevelEdge& y) { return x.Source == y.Source; };
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  return edges;
}
} // namespace

TangentHierarchy::TangentHierarchy(const OneRings& rings)
{
  const Index vertices = rings.NumberOfPoints();
  const std::vector<double> areas = AreasOf(rings);
  this->Fine.Radius = RadiusOf(areas);
  this->Fine.Start = { 0 };
  this->Coarse.Start = { 0 };
  this->MemberStart = { 0 };
  const std::vector<std::uint8_t> chosen = ChooseCenters(rings);
  std::vector<LevelEdge> steps;
  std::vector<LevelEdge> edges;
  std::vector<Index> numbers(static_cast<std::size_t>(vertices), -1);
  for (Index v = 0; v < vertices; ++v)
  {
    edges.clear();
    ForEdges(rings, v, [&](const LevelEdge& edge) { edges.push_back(edge); });
    AppendVertex(edges, v, areas, this->Fine.Radius, this->Fine);
    this->Fine.Centroids.emplace_back(CentroidDirection(rings, v, CentroidRadius * this->Fine.Radius));
    steps.push_back(StepToCenter(rings, chosen, v));
    this->ToCenter.emplace_back(std::conj(steps.back().Transport));
    if (chosen[v])
    {
      numbers[v] = static_cast<Index>(this->Centers.size());
      this->Centers.push_back(v);
      this->Coarse.Centroids.push_back(this->Fine.Centroids.back());
    }
  }

  std::vector<double> coarseAreas(this->Centers.size(), 0.0);
  std::vector<std::vector<Index>> members(this->Centers.size());
  for (Index v = 0; v < vertices; ++v)
  {
    this->Clusters.push_back(numbers[steps[v].Source]);
    members[this->Clusters[v]].push_back(v);
    coarseAreas[this->Clusters[v]] += areas[v];
  }
  this->Coarse.Radius = RadiusOf(coarseAreas);
  for (std::size_t a = 0; a < members.size(); ++a)
  {
    this->Members.insert(this->Members.end(), members[a].begin(), members[a].end());
    this->MemberStart.push_back(static_cast<Index>(this->Members.size()));
    const auto cluster = static_cast<Index>(a);
    AppendVertex(ClusterEdges(rings, this->Clusters, steps, members[a], cluster), cluster, coarseAreas,
      this->Coarse.Radius, this->Coarse);
  }
}

std::vector<Index> CentralVertices(const OneRings& rings, double part)
{
  const double least = part * RadiusOf(AreasOf(rings));
  std::vector<Index> found;
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    if (rings.RingStart[v] < rings.RingStart[v + 1] && std::abs(RingCentroid(rings, v)) < least)
    {
      found.push_back(v);
    }
  }
  return found;
}

std::vector<Index> RegularVertices(const OneRings& rings)
{
  std::vector<std::uint8_t> central(static_cast<std::size_t>(rings.NumberOfPoints()), 0);
  for (const Index v : CentralVertices(rings, CentroidRadius))
  {
    central[v] = 1;
  }
  std::vector<Index> found;
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    const auto begin = rings.Neighbors.begin() + rings.NeighborStart[v];
    const auto end = rings.Neighbors.begin() + rings.NeighborStart[v + 1];
    if (central[v] && std::any_of(begin, end, [&central](Index w) { return central[w] != 0; }))
    {
      found.push_back(v);
    }
  }
  return found;
}

} // namespace surfsynth
