// SPDX-License-Identifier: BSD-3-Clause
// Refinement and decimation of the test surfaces (declared in ExampleMeshes.h).
#include "ExampleMeshes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

namespace surfsynth::test
{
namespace
{

std::uint64_t EdgeKey(Index a, Index b)
{
  const auto low = static_cast<std::uint64_t>(std::min(a, b));
  const auto high = static_cast<std::uint64_t>(std::max(a, b));
  return low << 32 | high;
}

/// Edge collapses in the order of their quadric error.
class Decimator
{
public:
  explicit Decimator(const TriangleMesh& mesh)
    : Around(static_cast<std::size_t>(mesh.NumberOfPoints()))
    , Quadrics(Around.size(), Eigen::Matrix4d::Zero())
    , Stamps(Around.size(), 0)
  {
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      this->Points.push_back(mesh.Points.row(v));
    }
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      this->Triangles.push_back({ mesh.Triangles(f, 0), mesh.Triangles(f, 1), mesh.Triangles(f, 2) });
      const Eigen::Vector3d normal = this->Normal(this->Triangles.back());
      Eigen::Vector4d plane;
      plane << normal.normalized(), -normal.normalized().dot(this->At(mesh.Triangles(f, 0)));
      for (const Index v : this->Triangles.back())
      {
        this->Around[static_cast<std::size_t>(v)].push_back(f);
        this->Quadrics[static_cast<std::size_t>(v)] += normal.norm() * plane * plane.transpose();
      }
    }
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      this->Alive += this->Around[static_cast<std::size_t>(v)].empty() ? 0 : 1;
      this->Push(v, true);
    }
  }

  void Run(Index points)
  {
    while (this->Alive > points && !this->Queue.empty())
    {
      const Candidate edge = this->Queue.top();
      this->Queue.pop();
      if (this->Stamp(edge.A) + this->Stamp(edge.B) == edge.Stamps && this->MayCollapse(edge))
      {
        this->Collapse(edge);
      }
    }
  }

  TriangleMesh Mesh() const
  {
    std::vector<Index> ids(this->Points.size(), -1);
    TriangleMesh mesh;
    mesh.Points.resize(this->Alive, 3);
    Index next = 0;
    for (std::size_t v = 0; v < this->Points.size(); ++v)
    {
      if (!this->Around[v].empty())
      {
        mesh.Points.row(next) = this->Points[v];
        ids[v] = next++;
      }
    }
    std::vector<std::array<Index, 3>> left;
    std::copy_if(this->Triangles.begin(), this->Triangles.end(), std::back_inserter(left),
      [](const std::array<Index, 3>& triangle) { return triangle[0] >= 0; });
    mesh.Triangles.resize(static_cast<Eigen::Index>(left.size()), 3);
    for (std::size_t f = 0; f < left.size(); ++f)
    {
      for (std::size_t c = 0; c < 3; ++c)
      {
        mesh.Triangles(
          static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c)) = ids[static_cast<std::size_t>(left[f][c])];
      }
    }
    return mesh;
  }

private:
  struct Candidate
  {
    double Cost;
    Index A;
    Index B;
    int Stamps;
    Eigen::Vector3d Target;
    bool operator<(const Candidate& other) const { return this->Cost > other.Cost; } // lowest cost first
  };

  const Eigen::Vector3d& At(Index v) const { return this->Points[static_cast<std::size_t>(v)]; }
  int Stamp(Index v) const { return this->Stamps[static_cast<std::size_t>(v)]; }
  const std::vector<Index>& TrianglesOf(Index v) const { return this->Around[static_cast<std::size_t>(v)]; }
  const std::array<Index, 3>& Corners(Index f) const { return this->Triangles[static_cast<std::size_t>(f)]; }

  Eigen::Vector3d Normal(const std::array<Index, 3>& t) const
  {
    return (this->At(t[1]) - this->At(t[0])).cross(this->At(t[2]) - this->At(t[0]));
  }

  std::vector<Index> NeighborsOf(Index v) const
  {
    std::vector<Index> ids;
    for (const Index f : this->TrianglesOf(v))
    {
      for (const Index w : this->Corners(f))
      {
        if (w != v)
        {
          ids.push_back(w);
        }
      }
    }
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
  }

  bool OnBoundary(Index v) const { return this->NeighborsOf(v).size() != this->TrianglesOf(v).size(); }

  /// Queues the edges of @p v; all of them or only those to higher ids.
  void Push(Index v, bool onlyHigher)
  {
    for (const Index w : this->NeighborsOf(v))
    {
      if (onlyHigher && w < v)
      {
        continue;
      }
      const Eigen::Matrix4d quadric = this->Quadrics[static_cast<std::size_t>(v)] +
        this->Quadrics[static_cast<std::size_t>(w)];
      Candidate edge{ std::numeric_limits<double>::max(), v, w, this->Stamp(v) + this->Stamp(w), {} };
      for (const double t : { 0.0, 0.25, 0.5, 0.75, 1.0 })
      {
        const Eigen::Vector3d target = (1.0 - t) * this->At(v) + t * this->At(w);
        // A little of the edge length keeps flat regions even.
        const double cost = target.homogeneous().dot(quadric * target.homogeneous()) +
          1e-3 * (this->At(v) - this->At(w)).squaredNorm() * quadric.topLeftCorner<3, 3>().trace();
        if (cost < edge.Cost)
        {
          edge.Cost = cost;
          edge.Target = target;
        }
      }
      this->Queue.push(edge);
    }
  }

  bool MayCollapse(const Candidate& edge) const
  {
    if (this->OnBoundary(edge.A) || this->OnBoundary(edge.B))
    {
      return false;
    }
    // Link condition: the two vertices share exactly the two vertices opposite to their edge.
    const std::vector<Index> first = this->NeighborsOf(edge.A);
    const std::vector<Index> second = this->NeighborsOf(edge.B);
    std::vector<Index> shared;
    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(shared));
    if (shared.size() != 2 || this->NeighborsOf(shared[0]).size() < 4 || this->NeighborsOf(shared[1]).size() < 4 ||
      first.size() + second.size() < 8)
    {
      return false;
    }
    return this->KeepsOrientation(edge.A, edge.B, edge.Target) && this->KeepsOrientation(edge.B, edge.A, edge.Target);
  }

  /// True when the triangles of @p v without @p other stay well shaped and do not fold when @p v moves to @p target.
  bool KeepsOrientation(Index v, Index other, const Eigen::Vector3d& target) const
  {
    for (const Index f : this->TrianglesOf(v))
    {
      const std::array<Index, 3>& corners = this->Corners(f);
      if (std::find(corners.begin(), corners.end(), other) != corners.end())
      {
        continue;
      }
      std::array<Eigen::Vector3d, 3> p;
      for (std::size_t c = 0; c < 3; ++c)
      {
        p[c] = corners[c] == v ? target : this->At(corners[c]);
      }
      const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
      const Eigen::Vector3d before = this->Normal(corners);
      const double longest = std::max(
        { (p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm() });
      if (normal.dot(before) < 0.3 * normal.norm() * before.norm() || normal.norm() < 0.1 * longest)
      {
        return false;
      }
    }
    return true;
  }

  void Collapse(const Candidate& edge)
  {
    const auto a = static_cast<std::size_t>(edge.A);
    const auto b = static_cast<std::size_t>(edge.B);
    for (const Index f : std::vector<Index>(this->Around[b]))
    {
      std::array<Index, 3>& corners = this->Triangles[static_cast<std::size_t>(f)];
      if (std::find(corners.begin(), corners.end(), edge.A) != corners.end())
      {
        for (const Index v : corners)
        {
          std::vector<Index>& list = this->Around[static_cast<std::size_t>(v)];
          list.erase(std::find(list.begin(), list.end(), f));
        }
        corners = { -1, -1, -1 };
      }
      else
      {
        std::replace(corners.begin(), corners.end(), edge.B, edge.A);
        this->Around[a].push_back(f);
      }
    }
    this->Around[b].clear();
    this->Points[a] = edge.Target;
    this->Quadrics[a] += this->Quadrics[b];
    this->Stamps[a] += this->Stamps[b] + 1;
    this->Stamps[b] = -1000000; // no queued edge of b fits any more
    --this->Alive;
    this->Push(edge.A, false);
  }

  std::vector<Eigen::Vector3d> Points;
  std::vector<std::array<Index, 3>> Triangles; ///< all -1 once removed
  std::vector<std::vector<Index>> Around;      ///< triangles of each vertex; empty once removed
  std::vector<Eigen::Matrix4d> Quadrics;
  std::vector<int> Stamps; ///< grow with every change of a vertex
  std::priority_queue<Candidate> Queue;
  Index Alive = 0;
};

/// Cuts the triangle @p v at the middles of its edges: m[c] lies between v[c] and v[c + 1], -1 for none.
void AppendPieces(std::array<Index, 3> v, std::array<Index, 3> m, std::vector<std::array<Index, 3>>& triangles)
{
  const auto split = 3 - std::count(m.begin(), m.end(), -1);
  // Turn the triangle so that the split edges come first, or the unsplit one last.
  while ((split == 1 && m[0] < 0) || (split == 2 && m[2] >= 0))
  {
    std::rotate(v.begin(), v.begin() + 1, v.end());
    std::rotate(m.begin(), m.begin() + 1, m.end());
  }
  if (split == 0)
  {
    triangles.push_back(v);
  }
  else if (split == 1)
  {
    triangles.push_back({ v[0], m[0], v[2] });
    triangles.push_back({ m[0], v[1], v[2] });
  }
  else if (split == 2)
  {
    triangles.push_back({ v[0], m[0], m[1] });
    triangles.push_back({ m[0], v[1], m[1] });
    triangles.push_back({ v[0], m[1], v[2] });
  }
  else
  {
    triangles.push_back({ v[0], m[0], m[2] });
    triangles.push_back({ m[0], v[1], m[1] });
    triangles.push_back({ m[2], m[1], v[2] });
    triangles.push_back(m);
  }
}

} // namespace

TriangleMesh RefineWhere(const TriangleMesh& mesh, const std::function<bool(Index triangle)>& marked)
{
  std::unordered_map<std::uint64_t, Index> middles;
  middles.reserve(static_cast<std::size_t>(mesh.NumberOfTriangles()) * 3 / 2);
  std::vector<Eigen::RowVector3d> added;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (!marked(f))
    {
      continue;
    }
    for (int c = 0; c < 3; ++c)
    {
      const Index a = mesh.Triangles(f, c);
      const Index b = mesh.Triangles(f, (c + 1) % 3);
      const auto id = static_cast<Index>(mesh.NumberOfPoints() + static_cast<Index>(added.size()));
      if (middles.emplace(EdgeKey(a, b), id).second)
      {
        added.emplace_back(0.5 * (mesh.Points.row(a) + mesh.Points.row(b)));
      }
    }
  }
  std::vector<std::array<Index, 3>> triangles;
  triangles.reserve(static_cast<std::size_t>(mesh.NumberOfTriangles()) * 4);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    std::array<Index, 3> v;
    std::array<Index, 3> m;
    for (std::size_t c = 0; c < 3; ++c)
    {
      v[c] = mesh.Triangles(f, static_cast<Eigen::Index>(c));
      const auto middle = middles.find(EdgeKey(v[c], mesh.Triangles(f, static_cast<Eigen::Index>((c + 1) % 3))));
      m[c] = middle == middles.end() ? -1 : middle->second;
    }
    AppendPieces(v, m, triangles);
  }
  TriangleMesh result;
  result.Points.resize(mesh.Points.rows() + static_cast<Eigen::Index>(added.size()), 3);
  result.Points.topRows(mesh.Points.rows()) = mesh.Points;
  for (std::size_t i = 0; i < added.size(); ++i)
  {
    result.Points.row(mesh.Points.rows() + static_cast<Eigen::Index>(i)) = added[i];
  }
  result.Triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t f = 0; f < triangles.size(); ++f)
  {
    result.Triangles.row(static_cast<Eigen::Index>(f)) << triangles[f][0], triangles[f][1], triangles[f][2];
  }
  return result;
}

TriangleMesh Subdivide(const TriangleMesh& mesh)
{
  return RefineWhere(mesh, [](Index) { return true; });
}

TriangleMesh RefineToSize(const TriangleMesh& mesh, Index points, std::uint32_t seed)
{
  // With a fraction p of the triangles marked, an edge is split with probability 1 - (1 - p)^2.
  const double edges = 1.5 * mesh.NumberOfTriangles();
  const double split = std::min(1.0, std::max(0.0, (points - mesh.NumberOfPoints()) / edges));
  const double limit = (1.0 - std::sqrt(1.0 - split)) * 4294967296.0;
  return RefineWhere(mesh, [&](Index f) { return Mix(static_cast<std::uint64_t>(f), seed) < limit; });
}

TriangleMesh Decimate(const TriangleMesh& mesh, Index points)
{
  Decimator decimator(mesh);
  decimator.Run(points);
  return decimator.Mesh();
}

} // namespace surfsynth::test
