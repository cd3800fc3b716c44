// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/HalfEdges.h"
#include "Core/Mesh/SeparateSheets.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
/// Limit of the double area over the square of the longest edge: triangles below it are removed. Ten times that of the
/// mesh check, so that rounding on the way to it does not matter.
constexpr double FlatRatio = 2e-11;
/// A shortest edge of this part of the longest one is contracted; a flat triangle with a longer one has a corner on
/// the opposite edge.
constexpr double ShortRatio = 1e-3;
/// Rounds in which edges may be flipped; afterwards all is contracted, which ends for certain.
constexpr int FlippingRounds = 8;

/// Edges of a triangle, by which it is flat or a needle; edge k runs from corner k to k + 1.
struct TriangleEdges
{
  TriangleEdges(const TriangleMesh& mesh, std::int64_t f)
  {
    const auto t = mesh.Triangles.row(f);
    Eigen::Vector3d edge[3];
    for (int k = 0; k < 3; ++k)
    {
      edge[k] = (mesh.Points.row(t((k + 1) % 3)) - mesh.Points.row(t(k))).transpose();
      this->SquaredLength[k] = edge[k].squaredNorm();
    }
    this->DoubleArea = edge[0].cross(edge[1]).norm();
    this->SquaredLength.minCoeff(&this->Shortest);
    this->SquaredLength.maxCoeff(&this->Longest);
  }
  bool IsFlat() const
  {
    return !(this->DoubleArea > FlatRatio * this->SquaredLength[this->Longest] && this->DoubleArea > 1e-280);
  }
  bool IsNeedle() const
  {
    return !(this->SquaredLength[this->Shortest] > ShortRatio * ShortRatio * this->SquaredLength[this->Longest]);
  }

  Eigen::Vector3d SquaredLength;
  double DoubleArea = 0.0;
  int Shortest = 0;
  int Longest = 0;
};

std::vector<Index> FindFlat(const TriangleMesh& mesh)
{
  std::vector<Index> flat;
  std::mutex mutex;
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Index> part;
    for (std::int64_t f = begin; f < end; ++f)
    {
      if (TriangleEdges(mesh, f).IsFlat())
      {
        part.push_back(static_cast<Index>(f));
      }
    }
    std::lock_guard<std::mutex> lock(mutex);
    flat.insert(flat.end(), part.begin(), part.end());
  });
  std::sort(flat.begin(), flat.end());
  return flat;
}

/// Sets of points that become one: each is named by its lowest id.
class MergedPoints
{
public:
  explicit MergedPoints(Index points)
    : Parent(static_cast<std::size_t>(points))
  {
    std::iota(this->Parent.begin(), this->Parent.end(), 0);
  }
  Index Find(Index v)
  {
    while (this->Parent[v] != v)
    {
      v = this->Parent[v] = this->Parent[this->Parent[v]];
    }
    return v;
  }
  void Merge(Index a, Index b)
  {
    a = this->Find(a);
    b = this->Find(b);
    this->Parent[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<Index> Parent;
};

void Contract(TriangleMesh& mesh, const std::vector<Index>& flat)
{
  MergedPoints merged(mesh.NumberOfPoints());
  for (const Index f : flat)
  {
    const int k = TriangleEdges(mesh, f).Shortest;
    merged.Merge(mesh.Triangles(f, k), mesh.Triangles(f, (k + 1) % 3));
  }
  mesh.Triangles = mesh.Triangles.unaryExpr([&](Index v) { return merged.Find(v); });
}

/// Flips the longest edge of each triangle of @p flat with a triangle on its other side; one change per triangle.
void Flip(TriangleMesh& mesh, const std::vector<Index>& flat)
{
  const EdgeGroups edges(mesh);
  std::vector<char> changed(static_cast<std::size_t>(mesh.NumberOfTriangles()), 0);
  std::vector<std::int64_t> edgeOf(edges.HalfEdges.size());
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    std::for_each(edges.Begin(e), edges.End(e), [&](HalfEdge h) { edgeOf[h] = e; });
  }
  for (const Index f : flat)
  {
    const HalfEdge h = 3 * HalfEdge(f) + TriangleEdges(mesh, f).Longest;
    const std::int64_t e = edgeOf[h];
    const HalfEdge* other = std::find_if(edges.Begin(e), edges.End(e), [&](HalfEdge g) {
      return !changed[g / 3] && g / 3 != f && !changed[f] && IsForward(mesh, g) != IsForward(mesh, h);
    });
    if (other == edges.End(e))
    {
      continue; // next to a triangle that has changed: in the next round
    }
    const Index g = static_cast<Index>(*other / 3);
    const Index a = StartOf(mesh, h), b = EndOf(mesh, h), c = ApexOf(mesh, h), d = ApexOf(mesh, *other);
    mesh.Triangles.row(f) << a, d, c;
    mesh.Triangles.row(g) << d, b, c;
    changed[f] = changed[g] = 1;
  }
}
} // namespace

TriangleMesh RemoveDegenerateTriangles(const TriangleMesh& mesh)
{
  MeshWithEdges clean = WithoutFlatPairs(mesh);
  RequireBalanced(clean.Mesh, clean.Edges, "RemoveDegenerateTriangles");
  TriangleMesh& result = clean.Mesh;
  std::vector<Index> flat = FindFlat(result);
  for (int round = 0; !flat.empty(); ++round)
  {
    const auto rest = std::stable_partition(flat.begin(), flat.end(),
      [&](Index f) { return round >= FlippingRounds || TriangleEdges(result, f).IsNeedle(); });
    if (rest == flat.begin())
    {
      Flip(result, flat);
    }
    else
    {
      Contract(result, std::vector<Index>(flat.begin(), rest));
    }
    result = WithoutFlatPairs(std::move(result)).Mesh;
    flat = FindFlat(result);
  }
  return WithoutUnusedPoints(result);
}

} // namespace surfsynth
