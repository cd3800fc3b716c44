// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/MeshTopology.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <numeric>

namespace surfsynth
{

namespace
{
void RequireProperTriangles(const TriangleMesh& mesh)
{
  const Index count = mesh.NumberOfPoints();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const bool inRange = t.minCoeff() >= 0 && t.maxCoeff() < count;
    if (!inRange || t(0) == t(1) || t(1) == t(2) || t(2) == t(0))
    {
      throw InvalidInput("MeshTopology: triangle " + std::to_string(f) + " has vertices " + std::to_string(t(0)) +
        ", " + std::to_string(t(1)) + ", " + std::to_string(t(2)) + "; expected three different ids in [0, " +
        std::to_string(count) + ").");
    }
  }
}

/// Sorts the few ids of one row. At the dozen that a vertex has, placing each id by the number of those before it is
/// the fastest: there is no branch to mispredict.
void SortFew(Index* begin, const Index* end)
{
  constexpr int Few = 32;
  const int count = static_cast<int>(end - begin);
  if (count > Few)
  {
    std::sort(begin, begin + count);
    return;
  }
  Index sorted[Few];
  for (int i = 0; i < count; ++i)
  {
    const Index value = begin[i];
    int place = 0;
    for (int j = 0; j < i; ++j)
    {
      place += begin[j] <= value ? 1 : 0;
    }
    for (int j = i + 1; j < count; ++j)
    {
      place += begin[j] < value ? 1 : 0;
    }
    sorted[place] = value;
  }
  std::copy_n(sorted, count, begin);
}

/// Sorts the ids of one row and keeps each once, with its number of occurrences (saturated at 255). Returns the number
/// of ids kept.
Index CountEqualIds(Index* begin, const Index* end, std::uint8_t* counts)
{
  SortFew(begin, end);
  Index unique = 0;
  for (const Index* id = begin; id < end; ++unique)
  {
    const Index value = *id;
    int count = 0;
    for (; id < end && *id == value; ++id)
    {
      ++count;
    }
    begin[unique] = value;
    counts[unique] = static_cast<std::uint8_t>(std::min(count, 255));
  }
  return unique;
}
} // namespace

MeshTopology::MeshTopology(const TriangleMesh& mesh)
{
  RequireProperTriangles(mesh);
  this->PlaceCorners(mesh);
  this->FindNeighbors(mesh);
}

void MeshTopology::PlaceCorners(const TriangleMesh& mesh)
{
  const Index* corners = mesh.Triangles.data();
  const std::int64_t count = mesh.Triangles.size();
  auto& start = this->VertexTriangleStart;
  start.assign(static_cast<std::size_t>(mesh.NumberOfPoints()) + 1, 0);
  for (std::int64_t c = 0; c < count; ++c)
  {
    ++start[corners[c] + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  this->CornerPlace.resize(static_cast<std::size_t>(count));
  std::vector<Index> next(start.begin(), start.end() - 1);
  for (std::int64_t c = 0; c < count; ++c)
  {
    this->CornerPlace[c] = next[corners[c]]++;
  }
  this->VertexTriangles.resize(this->CornerPlace.size());
  ParallelFor(count, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end; ++c)
    {
      this->VertexTriangles[this->CornerPlace[c]] = static_cast<Index>(c / 3);
    }
  });
}

void MeshTopology::FindNeighbors(const TriangleMesh& mesh)
{
  // The other two corners of each triangle around v, sorted: equal ids in a row are one neighbour, and their number is
  // that of the triangles on the edge. Compacted in place, then moved together.
  const Index* corners = mesh.Triangles.data();
  LargeArray<Index> others(2 * this->CornerPlace.size());
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        const std::int64_t place = this->CornerPlace[3 * f + k];
        others[2 * place] = corners[3 * f + (k + 1) % 3];
        others[2 * place + 1] = corners[3 * f + (k + 2) % 3];
      }
    }
  });
  LargeArray<std::uint8_t> multiplicity(others.size());
  const auto row = [this](std::int64_t v) { return 2 * std::int64_t(this->VertexTriangleStart[v]); };
  const Index points = mesh.NumberOfPoints();
  this->NeighborStart.assign(static_cast<std::size_t>(points) + 1, 0);
  ParallelFor(points, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      this->NeighborStart[v + 1] = CountEqualIds(
        others.data() + row(v), others.data() + row(v + 1), multiplicity.data() + row(v));
    }
  });
  std::partial_sum(this->NeighborStart.begin(), this->NeighborStart.end(), this->NeighborStart.begin());
  this->Neighbors.resize(static_cast<std::size_t>(this->NeighborStart.back()));
  this->EdgeTriangles.resize(this->Neighbors.size());
  ParallelFor(points, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      const Index to = this->NeighborStart[v];
      const Index count = this->NeighborStart[v + 1] - to;
      std::copy_n(others.data() + row(v), count, this->Neighbors.begin() + to);
      std::copy_n(multiplicity.data() + row(v), count, this->EdgeTriangles.begin() + to);
    }
  });
}

MeshComponents ComputeComponents(const MeshTopology& topology, const Eigen::VectorXd& mass)
{
  const Index points = topology.NumberOfPoints();
  MeshComponents components;
  components.OfVertex.assign(static_cast<std::size_t>(points), -1);
  std::vector<Index> queue;
  for (Index start = 0; start < points; ++start)
  {
    const bool used = topology.VertexTriangleStart[start] != topology.VertexTriangleStart[start + 1];
    if (!used || components.OfVertex[start] >= 0)
    {
      continue;
    }
    // Corners, directed edges and vertices: three corners to a face, two directions to an edge.
    std::int64_t corners = 0;
    std::int64_t directedEdges = 0;
    double area = 0.0;
    bool closed = true;
    queue.assign(1, start);
    components.OfVertex[start] = components.Count;
    for (std::size_t head = 0; head < queue.size(); ++head)
    {
      const Index v = queue[head];
      area += mass[v];
      corners += topology.VertexTriangleStart[v + 1] - topology.VertexTriangleStart[v];
      directedEdges += topology.NeighborStart[v + 1] - topology.NeighborStart[v];
      for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
      {
        closed = closed && topology.EdgeTriangles[k] != 1;
        Index& component = components.OfVertex[topology.Neighbors[k]];
        if (component < 0)
        {
          component = components.Count;
          queue.push_back(topology.Neighbors[k]);
        }
      }
    }
    components.Area.push_back(area);
    components.EulerCharacteristic.push_back(static_cast<std::int64_t>(queue.size()) - directedEdges / 2 + corners / 3);
    components.Closed.push_back(closed);
    ++components.Count;
  }
  return components;
}

} // namespace surfsynth
