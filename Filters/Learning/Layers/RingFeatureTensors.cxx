// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/RingFeatureTensors.h"

#include "Core/Mesh/MeshTopology.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

namespace surfsynth
{

namespace
{
/// Vertices of the rings 0 to R around a vertex; none beyond the last.
using VertexRings = std::vector<std::vector<Index>>;

/// @param centerOf [V], center of the last search that found each vertex
VertexRings RingsAround(const MeshTopology& topology, Index center, int rings, std::vector<Index>& centerOf)
{
  VertexRings found(1, { center });
  centerOf[center] = center;
  for (int ring = 1; ring <= rings; ++ring)
  {
    std::vector<Index> next;
    for (const Index v : found.back())
    {
      for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
      {
        const Index w = topology.Neighbors[k];
        if (centerOf[w] != center)
        {
          centerOf[w] = center;
          next.push_back(w);
        }
      }
    }
    found.push_back(next.empty() ? found.back() : std::move(next));
  }
  return found;
}

bool AreWhole(const MeshTopology& topology, const VertexRings& rings)
{
  return std::none_of(rings.begin(), rings.end() - 1, [&](const std::vector<Index>& ring) {
    return std::any_of(ring.begin(), ring.end(), [&](Index v) { return topology.IsOnBoundary(v); });
  });
}

/// The table of one ring of all centers. @param rings [N]
RingTable TableOf(const std::vector<VertexRings>& rings, std::size_t ring, const torch::TensorOptions& options)
{
  constexpr std::int64_t quartiles = FeaturesOfRing - 1;
  const auto count = static_cast<std::int64_t>(rings.size());
  std::size_t width = 0;
  for (const VertexRings& around : rings)
  {
    width = std::max(width, around[ring].size());
  }
  const torch::Tensor vertices = torch::empty({ count, static_cast<std::int64_t>(width) }, torch::kInt64);
  const torch::Tensor counts = torch::empty({ count, 1 }, torch::kFloat64);
  const torch::Tensor isOwn = torch::empty({ count, 1, 1 }, torch::kFloat64);
  for (std::int64_t n = 0; n < count; ++n)
  {
    const VertexRings& around = rings[static_cast<std::size_t>(n)];
    auto* row = vertices.data_ptr<std::int64_t>() + n * static_cast<std::int64_t>(width);
    std::fill_n(std::copy(around[ring].begin(), around[ring].end(), row), width - around[ring].size(), around[0][0]);
    counts.data_ptr<double>()[n] = static_cast<double>(around[ring].size());
    isOwn.data_ptr<double>()[n] = around[ring] == around[ring - 1] ? 0.0 : 1.0;
  }
  const torch::Tensor places = (counts - 1.0) * torch::linspace(0.0, 1.0, quartiles, torch::kFloat64).unsqueeze(0);
  RingTable table;
  table.Vertices = vertices.to(options.device());
  table.Missing =
    (torch::arange(static_cast<double>(width), torch::kFloat64).unsqueeze(0) >= counts).to(options.device());
  table.Counts = counts.to(options);
  table.IsOwn = isOwn.to(options);
  table.Lower = places.floor().to(options.device(), torch::kInt64);
  table.Upper = places.ceil().to(options.device(), torch::kInt64);
  table.Share = (places - places.floor()).to(options);
  return table;
}

/// Unit normals of the neighborhoods, [N, 3]: along the sums of the area vectors of their vertices.
torch::Tensor NormalsOf(const FaceTables& faces, const RingTables& tables, const torch::Tensor& positions)
{
  const torch::NoGradGuard noGradients;
  const torch::Tensor corners = TakeRows(positions, faces.Triangles);
  const torch::Tensor first = corners.select(1, 0);
  const torch::Tensor areas = torch::linalg_cross(corners.select(1, 1) - first, corners.select(1, 2) - first, -1);
  const torch::Tensor vectors = SumRows(areas.unsqueeze(1).expand_as(corners), faces.Triangles, faces.Vertices);
  torch::Tensor sum = TakeRows(vectors, tables.Centers);
  for (const RingTable& ring : tables.Rings)
  {
    const torch::Tensor ofRing = TakeRows(vectors, ring.Vertices).masked_fill(ring.Missing.unsqueeze(-1), 0.0);
    sum = sum + (ring.IsOwn * ofRing).sum(1);
  }
  constexpr double smallest = 1e-30;
  return sum / sum.norm(2, -1, true).clamp_min(smallest);
}
} // namespace

RingTables::RingTables(const TriangleMesh& mesh, int rings, const torch::TensorOptions& options)
{
  const MeshTopology topology(mesh);
  std::vector<Index> centerOf(static_cast<std::size_t>(mesh.NumberOfPoints()), -1);
  std::vector<VertexRings> whole, all;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (topology.NeighborStart[v] < topology.NeighborStart[v + 1])
    {
      VertexRings around = RingsAround(topology, v, rings, centerOf);
      (AreWhole(topology, around) ? whole : all).push_back(std::move(around));
    }
  }
  const std::vector<VertexRings>& kept = whole.empty() ? all : whole;
  std::vector<std::int64_t> centers;
  for (const VertexRings& around : kept)
  {
    centers.push_back(around[0][0]);
  }
  this->Centers = torch::tensor(centers, torch::kInt64).to(options.device());
  for (int ring = 1; ring <= rings; ++ring)
  {
    this->Rings.push_back(TableOf(kept, static_cast<std::size_t>(ring), options));
  }
}

RingTables RingTables::Take(const torch::Tensor& rows) const
{
  RingTables taken;
  taken.Centers = this->Centers.index_select(0, rows);
  for (const RingTable& ring : this->Rings)
  {
    const auto of = [&rows](const torch::Tensor& table) { return table.index_select(0, rows); };
    taken.Rings.push_back({ of(ring.Vertices), of(ring.Missing), of(ring.Counts), of(ring.IsOwn), of(ring.Lower),
      of(ring.Upper), of(ring.Share) });
  }
  return taken;
}

torch::Tensor RingFeatureTensor(const FaceTables& faces, const RingTables& tables, const torch::Tensor& positions)
{
  constexpr double beyondAll = 1e30;       // height of what is missing
  constexpr double smallestSquare = 1e-12; // a distance of 0 has no derivative
  const torch::Tensor normals = NormalsOf(faces, tables, positions).unsqueeze(1);
  const torch::Tensor centers = TakeRows(positions, tables.Centers).unsqueeze(1);
  std::vector<torch::Tensor> features;
  for (const RingTable& ring : tables.Rings)
  {
    const torch::Tensor offsets = TakeRows(positions, ring.Vertices) - centers;
    const torch::Tensor heights = (offsets * normals).sum(-1);
    const torch::Tensor sorted = std::get<0>(heights.masked_fill(ring.Missing, beyondAll).sort(1));
    features.push_back(torch::lerp(sorted.gather(1, ring.Lower), sorted.gather(1, ring.Upper), ring.Share));
    const torch::Tensor squares = offsets.square().sum(-1) - heights.square();
    features.push_back(
      squares.clamp_min(smallestSquare).sqrt().masked_fill(ring.Missing, 0.0).sum(1, true) / ring.Counts);
  }
  return torch::cat(features, 1);
}

} // namespace surfsynth
