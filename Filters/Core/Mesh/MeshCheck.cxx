// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/MeshCheck.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Counts the ids in [0, count) for which @p isDefect(id) holds, in parallel.
template <typename Predicate>
MeshFinding Count(MeshDefect defect, std::int64_t count, const Predicate& isDefect)
{
  MeshFinding total{ defect };
  total.First = count;
  std::mutex mutex;
  ParallelFor(count, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t found = 0;
    std::int64_t first = count;
    for (std::int64_t id = begin; id < end; ++id)
    {
      if (isDefect(id))
      {
        first = std::min(first, id);
        ++found;
      }
    }
    std::lock_guard<std::mutex> lock(mutex);
    total.Count += found;
    total.First = std::min(total.First, first);
  });
  return total;
}

/// Counts the edges from @p v to higher vertices for which @p visit(k) holds, with k their place among the neighbours.
template <typename Visit>
std::int64_t CountEdges(const MeshTopology& topology, Index v, const Visit& visit)
{
  std::int64_t count = 0;
  for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
  {
    count += topology.Neighbors[k] > v && visit(k) ? 1 : 0;
  }
  return count;
}

/// Counts the edges for which @p isDefect(v, k) holds, v the lower vertex and k its place among the neighbours of v.
template <typename Predicate>
MeshFinding CountEdgeDefects(MeshDefect defect, const MeshTopology& topology, const Predicate& isDefect)
{
  std::int64_t edges = 0;
  const auto anyAt = [&](std::int64_t v) {
    return CountEdges(topology, static_cast<Index>(v), [&](Index k) { return isDefect(static_cast<Index>(v), k); }) > 0;
  };
  MeshFinding finding = Count(defect, topology.NumberOfPoints(), anyAt);
  if (finding.Count > 0)
  {
    for (Index v = static_cast<Index>(finding.First); v < topology.NumberOfPoints(); ++v)
    {
      edges += CountEdges(topology, v, [&](Index k) { return isDefect(v, k); });
    }
    finding.Count = edges;
  }
  return finding;
}

/// Triangles that run from @p v to @p other.
int RunsFromTo(const TriangleMesh& mesh, const MeshTopology& topology, Index v, Index other)
{
  // Looked for around the end with fewer triangles: a pole may have very many.
  const auto valence = [&](Index p) { return topology.VertexTriangleStart[p + 1] - topology.VertexTriangleStart[p]; };
  const Index at = valence(other) < valence(v) ? other : v;
  int runs = 0;
  for (Index k = topology.VertexTriangleStart[at]; k < topology.VertexTriangleStart[at + 1]; ++k)
  {
    const auto t = mesh.Triangles.row(topology.VertexTriangles[k]);
    for (int corner = 0; corner < 3; ++corner)
    {
      runs += t(corner) == v && t((corner + 1) % 3) == other ? 1 : 0;
    }
  }
  return runs;
}

MeshFinding CountComponents(const MeshTopology& topology)
{
  const MeshComponents components = ComputeComponents(topology, Eigen::VectorXd::Zero(topology.NumberOfPoints()));
  MeshFinding finding{ MeshDefect::SeveralComponents };
  if (components.Count > 1)
  {
    finding.Count = components.Count;
    finding.First = std::find(components.OfVertex.begin(), components.OfVertex.end(), 1) - components.OfVertex.begin();
  }
  return finding;
}

void KeepIfAny(const MeshFinding& finding, std::vector<MeshFinding>& findings)
{
  if (finding.Count > 0)
  {
    findings.push_back(finding);
  }
}

/// Defects that prevent the search for others.
std::vector<MeshFinding> CheckTriangles(const TriangleMesh& mesh)
{
  const auto& t = mesh.Triangles;
  const Index points = mesh.NumberOfPoints();
  const MeshFinding outOfRange = Count(MeshDefect::IndexOutOfRange, t.rows(),
    [&](std::int64_t f) { return t.row(f).minCoeff() < 0 || t.row(f).maxCoeff() >= points; });
  if (outOfRange.Count > 0)
  {
    return { outOfRange };
  }
  std::vector<MeshFinding> findings;
  const auto keep = [&](const MeshFinding& finding) { KeepIfAny(finding, findings); };
  const auto finite = [&](Index v) { return mesh.Points.row(v).allFinite(); };
  const auto finiteTriangle = [&](std::int64_t f) { return finite(t(f, 0)) && finite(t(f, 1)) && finite(t(f, 2)); };
  const auto repeats = [&](std::int64_t f) { return t(f, 0) == t(f, 1) || t(f, 1) == t(f, 2) || t(f, 2) == t(f, 0); };
  // Vertices are looked at from the triangles that use them; the exact count is only made when there is one.
  if (Count(MeshDefect::NonFinitePoint, t.rows(), [&](std::int64_t f) { return !finiteTriangle(f); }).Count > 0)
  {
    std::vector<bool> used(static_cast<std::size_t>(points), false);
    std::for_each(t.data(), t.data() + t.size(), [&](Index v) { used[v] = true; });
    keep(Count(
      MeshDefect::NonFinitePoint, points, [&](std::int64_t v) { return used[v] && !finite(static_cast<Index>(v)); }));
  }
  keep(Count(MeshDefect::RepeatedVertex, t.rows(), repeats));
  keep(Count(MeshDefect::DegenerateTriangle, t.rows(),
    [&](std::int64_t f) { return !repeats(f) && finiteTriangle(f) && IsDegenerateTriangle(mesh, f); }));
  return findings;
}

std::vector<MeshFinding> CheckTopology(
  const TriangleMesh& mesh, const MeshTopology& topology, const MeshRequirements& requirements)
{
  std::vector<MeshFinding> findings;
  const auto keep = [&](const MeshFinding& finding) { KeepIfAny(finding, findings); };
  const auto& triangles = topology.EdgeTriangles;
  if (requirements.ManifoldEdges)
  {
    keep(CountEdgeDefects(MeshDefect::NonManifoldEdge, topology, [&](Index, Index k) { return triangles[k] > 2; }));
  }
  if (requirements.ManifoldVertices && findings.empty())
  {
    keep(Count(MeshDefect::NonManifoldVertex, topology.NumberOfPoints(),
      [&](std::int64_t v) { return !HasSingleFan(mesh, topology, v); }));
  }
  if (requirements.ConsistentWinding)
  {
    keep(CountEdgeDefects(MeshDefect::InconsistentWinding, topology, [&](Index v, Index k) {
      return triangles[k] == 2 && RunsFromTo(mesh, topology, v, topology.Neighbors[k]) != 1;
    }));
  }
  if (requirements.Closed)
  {
    keep(CountEdgeDefects(MeshDefect::BoundaryEdge, topology, [&](Index, Index k) { return triangles[k] == 1; }));
  }
  if (requirements.SingleComponent)
  {
    keep(CountComponents(topology));
  }
  return findings;
}

std::string DescribeFinding(const MeshFinding& finding, std::int64_t first)
{
  const std::string count = std::to_string(finding.Count);
  const std::string id = std::to_string(first);
  switch (finding.Defect)
  {
    case MeshDefect::IndexOutOfRange:
      return count + " cell(s) that name a point that does not exist, first cell " + id +
        "; the dataset is inconsistent: write it again with the program that made it, or let vtkSurfaceRepairFilter "
        "leave them out.";
    case MeshDefect::NonFinitePoint:
      return count + " point(s) with a NaN or infinite coordinate, first point " + id +
        "; vtkSurfaceRepairFilter leaves them out and closes the holes.";
    case MeshDefect::RepeatedVertex:
      return count + " cell(s) that use a point twice, first cell " + id +
        "; vtkSurfaceRepairFilter or vtkCleanPolyData removes them.";
    case MeshDefect::DegenerateTriangle:
      return count + " degenerate triangle(s) of zero area, first cell " + id +
        "; vtkSurfaceRepairFilter removes them, or vtkCleanPolyData (with a tolerance) where points coincide.";
    case MeshDefect::NonManifoldEdge:
      return count + " non-manifold edge(s) with more than two triangles, first at point " + id +
        "; vtkSurfaceRepairFilter takes the sheets apart. vtkFeatureEdges shows them, vtkCleanPolyData removes "
        "duplicate cells.";
    case MeshDefect::NonManifoldVertex:
      return count + " non-manifold point(s) where several fans of triangles touch, first point " + id +
        "; vtkSurfaceRepairFilter gives each fan a point of its own.";
    case MeshDefect::InconsistentWinding:
      return count + " edge(s) whose two triangles are wound in opposite senses, first at point " + id +
        "; vtkSurfaceRepairFilter, or vtkPolyDataNormals with ConsistencyOn(), winds them alike.";
    case MeshDefect::BoundaryEdge:
      return count + " boundary edge(s) where a closed surface is needed, first at point " + id +
        "; vtkSurfaceRepairFilter with HoleFilling ALL_HOLES, or vtkFillHolesFilter, closes them.";
    case MeshDefect::SeveralComponents:
      return count + " connected components where one is needed, the second at point " + id +
        "; vtkSurfaceRepairFilter with KeepLargestComponentOn(), or vtkPolyDataConnectivityFilter, keeps the largest.";
  }
  return {};
}
} // namespace

bool HasTriangleIds(MeshDefect defect)
{
  return defect == MeshDefect::IndexOutOfRange || defect == MeshDefect::RepeatedVertex ||
    defect == MeshDefect::DegenerateTriangle;
}

bool IsDegenerateTriangle(const TriangleMesh& mesh, std::int64_t f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::Vector3d a = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
  const Eigen::Vector3d b = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
  const double longest = std::max({ a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm() });
  const double doubleArea = a.cross(b).norm();
  // Written so that an area or a length that overflows or underflows counts as degenerate.
  return !(doubleArea > 2e-12 * longest && doubleArea > 1e-290 && longest < 1e290);
}

bool HasSingleFan(const TriangleMesh& mesh, const MeshTopology& topology, std::int64_t v)
{
  const Index first = topology.VertexTriangleStart[v];
  const Index count = topology.VertexTriangleStart[v + 1] - first;
  if (count < 2)
  {
    return true;
  }
  // The other corners, each with the place of its triangle: triangles with the same one share an edge at v.
  std::vector<std::pair<Index, Index>> corners;
  corners.reserve(2 * static_cast<std::size_t>(count));
  for (Index k = 0; k < count; ++k)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      const Index id = mesh.Triangles(topology.VertexTriangles[first + k], corner);
      if (id != v)
      {
        corners.emplace_back(id, k);
      }
    }
  }
  std::sort(corners.begin(), corners.end());
  std::vector<Index> parent(static_cast<std::size_t>(count));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index k) {
    while (parent[k] != k)
    {
      k = parent[k] = parent[parent[k]];
    }
    return k;
  };
  Index fans = count;
  for (std::size_t k = 1; k < corners.size(); ++k)
  {
    if (corners[k - 1].first == corners[k].first)
    {
      const Index a = root(corners[k - 1].second);
      const Index b = root(corners[k].second);
      fans -= a != b ? 1 : 0;
      parent[a] = b;
    }
  }
  return fans == 1;
}

ProperTriangles KeepProperTriangles(const TriangleMesh& mesh)
{
  ProperTriangles proper;
  proper.Mesh.Points = mesh.Points;
  const Index points = mesh.NumberOfPoints();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const bool inRange = t.minCoeff() >= 0 && t.maxCoeff() < points;
    if (inRange && t(0) != t(1) && t(1) != t(2) && t(2) != t(0))
    {
      proper.Original.push_back(f);
    }
  }
  proper.Mesh.Triangles.resize(static_cast<Eigen::Index>(proper.Original.size()), 3);
  for (std::size_t k = 0; k < proper.Original.size(); ++k)
  {
    proper.Mesh.Triangles.row(static_cast<Eigen::Index>(k)) = mesh.Triangles.row(proper.Original[k]);
  }
  return proper;
}

std::vector<MeshFinding> InspectMesh(
  const TriangleMesh& mesh, const ProperTriangles& proper, const MeshTopology& topology)
{
  std::vector<MeshFinding> findings = CheckTriangles(mesh);
  const auto keep = [&](const std::vector<MeshFinding>& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  };
  if (!findings.empty() && findings.front().Defect == MeshDefect::IndexOutOfRange)
  {
    // CheckTriangles() stopped there. Repeated vertices are counted here, and the rest on the proper triangles.
    const Index points = mesh.NumberOfPoints();
    const auto& t = mesh.Triangles;
    const auto repeats = [&](std::int64_t f) {
      return t.row(f).minCoeff() >= 0 && t.row(f).maxCoeff() < points &&
        (t(f, 0) == t(f, 1) || t(f, 1) == t(f, 2) || t(f, 2) == t(f, 0));
    };
    KeepIfAny(Count(MeshDefect::RepeatedVertex, t.rows(), repeats), findings);
    std::vector<MeshFinding> others = CheckTriangles(proper.Mesh);
    for (MeshFinding& finding : others)
    {
      finding.First = HasTriangleIds(finding.Defect) ? proper.Original[finding.First] : finding.First;
    }
    keep(others);
  }
  MeshRequirements all;
  all.ConsistentWinding = all.Closed = all.SingleComponent = true;
  keep(CheckTopology(proper.Mesh, topology, all));
  MeshRequirements vertices; // apart, because they are only looked for where nothing else is wrong
  vertices.ManifoldEdges = false;
  vertices.ManifoldVertices = true;
  keep(CheckTopology(proper.Mesh, topology, vertices));
  std::stable_sort(
    findings.begin(), findings.end(), [](const MeshFinding& a, const MeshFinding& b) { return a.Defect < b.Defect; });
  return findings;
}

std::string RepairOf(MeshDefect defect)
{
  const std::string text = DescribeFinding({ defect, 1, 0 }, 0);
  return text.substr(text.find("; ") + 2);
}

std::vector<MeshFinding> CheckMesh(const TriangleMesh& mesh, const MeshRequirements& requirements)
{
  const std::vector<MeshFinding> findings = CheckTriangles(mesh);
  return findings.empty() ? CheckTopology(mesh, MeshTopology(mesh), requirements) : findings;
}

std::string DescribeFindings(
  const std::vector<MeshFinding>& findings, const std::function<std::int64_t(std::int64_t)>& cellOfTriangle)
{
  std::string text;
  for (const MeshFinding& finding : findings)
  {
    const bool isCell = HasTriangleIds(finding.Defect) && cellOfTriangle;
    text += (text.empty() ? "" : " Also ") +
      DescribeFinding(finding, isCell ? cellOfTriangle(finding.First) : finding.First);
  }
  return text;
}

MeshTopology RequireValidMesh(const TriangleMesh& mesh, const MeshRequirements& requirements,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle)
{
  const auto require = [&](const std::vector<MeshFinding>& findings) {
    if (!findings.empty())
    {
      throw InvalidInput("The mesh has " + DescribeFindings(findings, cellOfTriangle));
    }
  };
  require(CheckTriangles(mesh));
  MeshTopology topology(mesh);
  require(CheckTopology(mesh, topology, requirements));
  return topology;
}

} // namespace surfsynth
