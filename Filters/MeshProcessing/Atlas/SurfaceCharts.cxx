// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Atlas/SurfaceCharts.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
/// Sets of corners that are one point.
class CornerSets
{
public:
  explicit CornerSets(std::size_t corners)
    : Parent(corners)
  {
    std::iota(this->Parent.begin(), this->Parent.end(), 0);
  }
  Index Root(Index c)
  {
    while (this->Parent[c] != c)
    {
      c = this->Parent[c] = this->Parent[this->Parent[c]];
    }
    return c;
  }
  void Unite(Index a, Index b)
  {
    a = this->Root(a);
    b = this->Root(b);
    this->Parent[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<Index> Parent;
};

int CornerOf(const TriangleMesh& mesh, Index f, Index v)
{
  return mesh.Triangles(f, 0) == v ? 0 : (mesh.Triangles(f, 1) == v ? 1 : 2);
}
} // namespace

ChartCutter::ChartCutter(const TriangleMesh& mesh, const MeshTopology& topology)
  : Mesh(mesh)
  , Adjacency(mesh, topology)
  , Place(static_cast<std::size_t>(mesh.NumberOfTriangles()), -1)
{}

std::vector<std::vector<Index>> ChartCutter::ConnectedParts(
  const std::vector<Index>& triangles, const std::vector<std::size_t>& labels)
{
  for (std::size_t k = 0; k < triangles.size(); ++k)
  {
    this->Place[triangles[k]] = static_cast<Index>(k);
  }
  std::vector<std::vector<Index>> parts;
  for (const Index first : triangles)
  {
    if (this->Place[first] < 0)
    {
      continue;
    }
    std::vector<Index> part{ first };
    const std::size_t label = labels.empty() ? 0 : labels[this->Place[first]];
    this->Place[first] = -1;
    for (std::size_t head = 0; head < part.size(); ++head)
    {
      for (int side = 0; side < 3; ++side)
      {
        const Index g = this->Adjacency.Across(part[head], side);
        if (g >= 0 && this->Place[g] >= 0 && (labels.empty() || labels[this->Place[g]] == label))
        {
          this->Place[g] = -1;
          part.push_back(g);
        }
      }
    }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

SurfaceChart ChartCutter::Cut(const std::vector<Index>& triangles)
{
  const auto count = static_cast<Index>(triangles.size());
  for (Index k = 0; k < count; ++k)
  {
    this->Place[triangles[k]] = k;
  }
  CornerSets sets(3 * triangles.size());
  std::int64_t boundary = 0;
  for (Index k = 0; k < count; ++k)
  {
    const Index f = triangles[k];
    for (int side = 0; side < 3; ++side)
    {
      const Index g = this->Adjacency.Across(f, side);
      if (g < 0 || this->Place[g] < 0)
      {
        ++boundary;
        continue;
      }
      for (const int corner : { side, (side + 1) % 3 })
      {
        sets.Unite(3 * k + corner, 3 * this->Place[g] + CornerOf(this->Mesh, g, this->Mesh.Triangles(f, corner)));
      }
    }
  }
  SurfaceChart chart;
  chart.Triangles = triangles;
  chart.Mesh.Triangles.resize(count, 3);
  chart.Mesh.Points.resize(3 * std::int64_t(count), 3);
  std::vector<Index> id(3 * triangles.size(), -1);
  Index points = 0;
  for (Index c = 0; c < 3 * count; ++c)
  {
    Index& point = id[sets.Root(c)];
    if (point < 0)
    {
      point = points++;
      chart.Mesh.Points.row(point) = this->Mesh.Points.row(this->Mesh.Triangles(triangles[c / 3], c % 3));
    }
    chart.Mesh.Triangles(c / 3, c % 3) = point;
  }
  chart.Mesh.Points.conservativeResize(points, 3);
  const std::int64_t edges = (3 * std::int64_t(count) + boundary) / 2;
  chart.IsDisk = points - edges + count == 1;
  for (const Index f : triangles)
  {
    this->Place[f] = -1;
  }
  return chart;
}

} // namespace surfsynth
