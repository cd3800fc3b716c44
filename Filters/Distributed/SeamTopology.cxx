// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/SeamTopology.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace surfsynth
{

namespace
{
struct EdgeQuery
{
  std::int64_t Lower; ///< in the ids of the whole
  std::int64_t Upper;
  std::int64_t Triangles;
  std::int64_t Component;
};

struct EdgeReply
{
  std::int64_t Triangles; ///< of all ranks
  std::int64_t IsFirst;   ///< 1 on the lowest rank that has the edge
};

std::vector<std::vector<EdgeReply>> AnswerEdges(const std::vector<std::vector<EdgeQuery>>& received)
{
  struct Edge
  {
    std::int64_t Triangles = 0;
    std::size_t First = 0;
  };
  std::map<std::pair<std::int64_t, std::int64_t>, Edge> edges;
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    for (const EdgeQuery& query : received[rank])
    {
      const auto entry = edges.emplace(std::make_pair(query.Lower, query.Upper), Edge{ 0, rank });
      entry.first->second.Triangles += query.Triangles;
    }
  }
  std::vector<std::vector<EdgeReply>> replies;
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    replies.emplace_back();
    for (const EdgeQuery& query : received[rank])
    {
      const Edge& edge = edges.at({ query.Lower, query.Upper });
      replies.back().push_back({ edge.Triangles, edge.First == rank ? 1 : 0 });
    }
  }
  return replies;
}

/// Edges of the rank whose ends both lie on other ranks, too, and which others may have.
std::vector<EdgeQuery> EdgesOnSeams(
  const MergedPiece& piece, const MeshTopology& topology, const MeshComponents& components)
{
  std::vector<EdgeQuery> edges;
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    for (Index k = topology.NeighborStart[v]; piece.Shared[v] && k < topology.NeighborStart[v + 1]; ++k)
    {
      const Index other = topology.Neighbors[k];
      if (other > v && piece.Shared[other])
      {
        const auto ends = std::minmax(piece.WholeIds[v], piece.WholeIds[other]);
        edges.push_back({ ends.first, ends.second, topology.EdgeTriangles[k], components.OfVertex[v] });
      }
    }
  }
  return edges;
}

/// Component of one rank that has vertices on a seam.
struct SeamComponent
{
  std::int64_t Rank;
  std::int64_t Component;
  std::int64_t EulerCharacteristic;
  std::int64_t Closed;
  double Area;
};

/// Two components, by rank and number, that share a vertex.
using Junction = std::array<std::int64_t, 4>;

/// Root of @p k in a forest of components, whose paths it halves.
std::size_t RootOf(std::vector<std::size_t>& parents, std::size_t k)
{
  while (parents[k] != k)
  {
    parents[k] = parents[parents[k]];
    k = parents[k];
  }
  return k;
}

/// Corrects what the ranks count of edges and vertices on seams, so that the sum over ranks counts each once.
void CountSeamsOnce(const VertexOwners& owners, const std::vector<EdgeQuery>& edges,
  const std::vector<EdgeReply>& replies, const MeshTopology& topology, const MeshComponents& components,
  ComponentParts& parts)
{
  for (Index c = 0; c < components.Count; ++c)
  {
    parts.Closed[c] = true;
  }
  std::vector<std::int64_t> boundary(static_cast<std::size_t>(components.Count), 0);
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    const Index c = components.OfVertex[v];
    parts.EulerCharacteristic[std::max<Index>(c, 0)] -= c >= 0 && !owners.IsOwn(v) ? 1 : 0;
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      boundary[c] += topology.Neighbors[k] > v && topology.EdgeTriangles[k] == 1 ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < edges.size(); ++k)
  {
    const auto c = static_cast<std::size_t>(edges[k].Component);
    parts.EulerCharacteristic[c] += replies[k].IsFirst ? 0 : 1;
    boundary[c] -= edges[k].Triangles == 1 && replies[k].Triangles > 1 ? 1 : 0;
  }
  for (Index c = 0; c < components.Count; ++c)
  {
    parts.Closed[c] = boundary[c] == 0;
  }
}

void RequireManifoldSeams(
  const RankGroup& ranks, const std::vector<EdgeQuery>& edges, const std::vector<EdgeReply>& replies)
{
  std::int64_t count = 0;
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  for (std::size_t k = 0; k < edges.size(); ++k)
  {
    if (replies[k].Triangles > 2)
    {
      count += replies[k].IsFirst;
      first = std::min(first, edges[k].Lower);
    }
  }
  count = ranks.Total(count);
  const std::vector<std::int64_t> firsts = ranks.GatherAll(std::vector<std::int64_t>{ first });
  if (count > 0)
  {
    throw InvalidInput(
      DescribeFindings({ { MeshDefect::NonManifoldEdge, count, *std::min_element(firsts.begin(), firsts.end()) } }));
  }
}

/// Junctions of the rank's components with those of other ranks, each once.
std::vector<Junction> JunctionsOf(const VertexOwners& owners, const MeshComponents& components)
{
  std::set<Junction> junctions;
  for (std::size_t v = 0; v < components.OfVertex.size(); ++v)
  {
    if (components.OfVertex[v] >= 0 && !owners.IsOwn(static_cast<Index>(v)))
    {
      junctions.insert({ owners.Group().Rank(), components.OfVertex[v], owners.Owners[v], owners.OwnerComponents[v] });
    }
  }
  return { junctions.begin(), junctions.end() };
}

/// Components that others have junctions with, and those that have some themselves.
std::vector<SeamComponent> ComponentsOnSeams(
  const RankGroup& ranks, const std::vector<Junction>& junctions, const ComponentParts& parts)
{
  std::set<std::int64_t> own;
  for (const Junction& junction : junctions)
  {
    for (const std::size_t side : { 0U, 2U })
    {
      if (junction[side] == ranks.Rank())
      {
        own.insert(junction[side + 1]);
      }
    }
  }
  std::vector<SeamComponent> components;
  for (const std::int64_t c : own)
  {
    const auto k = static_cast<std::size_t>(c);
    components.push_back({ ranks.Rank(), c, parts.EulerCharacteristic[k], parts.Closed[k] ? 1 : 0, parts.Area[k] });
  }
  return ranks.GatherAll(components);
}

/// Sums over the components that junctions make one, in the order of ranks.
void SumOverJunctions(
  int rank, const std::vector<Junction>& junctions, std::vector<SeamComponent> components, ComponentParts& parts)
{
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> place;
  std::vector<std::size_t> parents(components.size());
  std::iota(parents.begin(), parents.end(), std::size_t(0));
  for (std::size_t k = 0; k < components.size(); ++k)
  {
    place.emplace(std::make_pair(components[k].Rank, components[k].Component), k);
  }
  for (const Junction& junction : junctions)
  {
    const std::size_t a = RootOf(parents, place.at({ junction[0], junction[1] }));
    const std::size_t b = RootOf(parents, place.at({ junction[2], junction[3] }));
    parents[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t k = 0; k < components.size(); ++k)
  {
    SeamComponent& root = components[RootOf(parents, k)];
    if (&root != &components[k])
    {
      root.Area += components[k].Area;
      root.EulerCharacteristic += components[k].EulerCharacteristic;
      root.Closed = root.Closed != 0 && components[k].Closed != 0 ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < components.size(); ++k)
  {
    if (components[k].Rank == rank)
    {
      const SeamComponent& root = components[RootOf(parents, k)];
      const auto c = static_cast<std::size_t>(components[k].Component);
      parts.Area[c] = root.Area;
      parts.EulerCharacteristic[c] = root.EulerCharacteristic;
      parts.Closed[c] = root.Closed != 0;
    }
  }
}
} // namespace

ComponentParts JoinComponents(
  const VertexOwners& owners, const MergedPiece& piece, const MeshTopology& topology, const MeshComponents& components)
{
  const RankGroup& ranks = owners.Group();
  const std::vector<EdgeQuery> edges = EdgesOnSeams(piece, topology, components);
  std::vector<int> homes;
  for (const EdgeQuery& edge : edges)
  {
    homes.push_back(static_cast<int>(edge.Lower % ranks.Count()));
  }
  const auto replies = ranks.Ask<EdgeReply>(edges, homes, AnswerEdges);
  RequireManifoldSeams(ranks, edges, replies);
  ComponentParts parts{ components.Area, components.EulerCharacteristic, components.Closed };
  if (components.Count > 0)
  {
    CountSeamsOnce(owners, edges, replies, topology, components, parts);
  }
  const std::vector<Junction> junctions = ranks.GatherAll(JunctionsOf(owners, components));
  SumOverJunctions(ranks.Rank(), junctions, ComponentsOnSeams(ranks, junctions, parts), parts);
  return parts;
}

} // namespace surfsynth
