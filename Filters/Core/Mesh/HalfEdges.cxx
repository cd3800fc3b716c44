// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/HalfEdges.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
void RequireValidIds(const TriangleMesh& mesh)
{
  const auto& t = mesh.Triangles;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (t.row(f).minCoeff() < 0 || t.row(f).maxCoeff() >= mesh.NumberOfPoints())
    {
      throw InvalidInput("EdgeGroups: triangle " + std::to_string(f) +
        " names a point that does not exist; ids from 0 to " + std::to_string(mesh.NumberOfPoints() - 1) +
        " are expected.");
    }
    if (t(f, 0) == t(f, 1) || t(f, 1) == t(f, 2) || t(f, 2) == t(f, 0))
    {
      throw InvalidInput(
        "EdgeGroups: triangle " + std::to_string(f) + " uses a point twice; three different points are expected.");
    }
  }
}

/// The triangles whose entry in @p keep is not 0.
TriangleMesh Select(const TriangleMesh& mesh, const std::vector<char>& keep)
{
  TriangleMesh selected;
  selected.Points = mesh.Points;
  selected.Triangles.resize(std::count_if(keep.begin(), keep.end(), [](char k) { return k != 0; }), 3);
  Index written = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (keep[f])
    {
      selected.Triangles.row(written++) = mesh.Triangles.row(f);
    }
  }
  return selected;
}

/// Marks, among the half-edges of one edge, triangles with the same apex that run in opposite directions, as many of
/// one direction as of the other. Looks at triangles only from the edge of their two lowest points, so that each is
/// looked at once.
void MarkFlatPairs(const TriangleMesh& mesh, const HalfEdge* begin, const HalfEdge* end, std::vector<char>& keep)
{
  for (const HalfEdge* h = begin; h != end; ++h)
  {
    const Index apex = ApexOf(mesh, *h);
    if (!keep[*h / 3] || apex < std::max(StartOf(mesh, *h), EndOf(mesh, *h)))
    {
      continue;
    }
    const HalfEdge* partner = std::find_if(h + 1, end, [&](HalfEdge other) {
      return keep[other / 3] && ApexOf(mesh, other) == apex && IsForward(mesh, other) != IsForward(mesh, *h);
    });
    if (partner != end)
    {
      keep[*h / 3] = keep[*partner / 3] = 0;
    }
  }
}
} // namespace

EdgeGroups::EdgeGroups(const TriangleMesh& mesh)
{
  RequireValidIds(mesh);
  const std::int64_t count = 3 * std::int64_t(mesh.NumberOfTriangles());
  const auto lower = [&](HalfEdge h) { return std::min(StartOf(mesh, h), EndOf(mesh, h)); };
  const auto upper = [&](HalfEdge h) { return std::max(StartOf(mesh, h), EndOf(mesh, h)); };
  std::vector<std::int64_t> row(static_cast<std::size_t>(mesh.NumberOfPoints()) + 1, 0);
  for (HalfEdge h = 0; h < count; ++h)
  {
    ++row[lower(h) + 1];
  }
  std::partial_sum(row.begin(), row.end(), row.begin());
  this->HalfEdges.resize(static_cast<std::size_t>(count));
  std::vector<std::int64_t> next(row.begin(), row.end() - 1);
  for (HalfEdge h = 0; h < count; ++h)
  {
    this->HalfEdges[next[lower(h)]++] = h;
  }
  ParallelFor(mesh.NumberOfPoints(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      std::sort(this->HalfEdges.begin() + row[v], this->HalfEdges.begin() + row[v + 1],
        [&](HalfEdge a, HalfEdge b) { return std::make_pair(upper(a), a) < std::make_pair(upper(b), b); });
    }
  });
  this->Start.reserve(static_cast<std::size_t>(count) / 2 + 1);
  for (std::int64_t k = 0; k < count; ++k)
  {
    const HalfEdge h = this->HalfEdges[k];
    if (k == 0 || lower(h) != lower(this->HalfEdges[k - 1]) || upper(h) != upper(this->HalfEdges[k - 1]))
    {
      this->Start.push_back(k);
    }
  }
  this->Start.push_back(count);
}

void RequireBalanced(const TriangleMesh& mesh, const EdgeGroups& edges, const char* function)
{
  std::int64_t unbalanced = 0;
  HalfEdge first = -1;
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    const auto forward = std::count_if(edges.Begin(e), edges.End(e), [&](HalfEdge h) { return IsForward(mesh, h); });
    if (2 * forward != edges.Size(e))
    {
      first = unbalanced++ == 0 ? *edges.Begin(e) : first;
    }
  }
  if (unbalanced > 0)
  {
    throw InvalidInput(std::string(function) + ": " + std::to_string(unbalanced) +
      " edge(s) have not as many triangles in one direction as in the other, first between the points " +
      std::to_string(StartOf(mesh, first)) + " and " + std::to_string(EndOf(mesh, first)) +
      "; a closed and consistently wound mesh is expected.");
  }
}

MeshWithEdges WithoutFlatPairs(TriangleMesh mesh)
{
  const auto& t = mesh.Triangles;
  std::vector<char> keep(static_cast<std::size_t>(mesh.NumberOfTriangles()), 1);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    keep[f] = t(f, 0) != t(f, 1) && t(f, 1) != t(f, 2) && t(f, 2) != t(f, 0);
  }
  if (std::find(keep.begin(), keep.end(), 0) != keep.end())
  {
    mesh = Select(mesh, keep);
  }
  EdgeGroups edges(mesh);
  keep.assign(static_cast<std::size_t>(mesh.NumberOfTriangles()), 1);
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    MarkFlatPairs(mesh, edges.Begin(e), edges.End(e), keep);
  }
  if (std::find(keep.begin(), keep.end(), 0) != keep.end())
  {
    mesh = Select(mesh, keep);
    edges = EdgeGroups(mesh);
  }
  return { std::move(mesh), std::move(edges) };
}

TriangleMesh WithoutUnusedPoints(const TriangleMesh& mesh)
{
  std::vector<Index> newId(static_cast<std::size_t>(mesh.NumberOfPoints()), -1);
  std::for_each(mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size(), [&](Index v) { newId[v] = 0; });
  Index used = 0;
  for (Index& id : newId)
  {
    id = id < 0 ? -1 : used++;
  }
  TriangleMesh compact;
  compact.Points.resize(used, 3);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (newId[v] >= 0)
    {
      compact.Points.row(newId[v]) = mesh.Points.row(v);
    }
  }
  compact.Triangles = mesh.Triangles.unaryExpr([&](Index v) { return newId[v]; });
  return compact;
}

} // namespace surfsynth
