// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/MeshStatistics.h"

#include "Core/Mesh/TriangleAdjacency.h"
#include "Core/Mesh/TriangleShapes.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace surfsynth
{

namespace
{
/// Counts the ids for which @p isOne(id) holds, and keeps the first.
template <typename Predicate>
MeshFinding CountIf(MeshDefect kind, std::int64_t count, const Predicate& isOne)
{
  MeshFinding finding{ kind };
  for (std::int64_t id = 0; id < count; ++id)
  {
    if (isOne(id))
    {
      finding.First = finding.Count == 0 ? id : finding.First;
      ++finding.Count;
    }
  }
  return finding;
}

bool IsUsed(const MeshTopology& topology, std::int64_t v)
{
  return topology.VertexTriangleStart[v] != topology.VertexTriangleStart[v + 1];
}

/// Used points that lie exactly where one with a lower id does.
MeshFinding FindCoincidentPoints(const TriangleMesh& mesh, const MeshTopology& topology)
{
  std::vector<Index> ids;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (IsUsed(topology, v) && mesh.Points.row(v).allFinite())
    {
      ids.push_back(v);
    }
  }
  const auto x = [&](Index v) {
    const double* p = mesh.Points.data() + 3 * static_cast<std::int64_t>(v);
    return std::array<double, 3>{ p[0], p[1], p[2] };
  };
  std::sort(ids.begin(), ids.end(), [&](Index a, Index b) {
    const auto pa = x(a);
    const auto pb = x(b);
    return pa < pb || (pa == pb && a < b);
  });
  MeshFinding finding{ MeshDefect::IndexOutOfRange };
  for (std::size_t k = 1; k < ids.size(); ++k)
  {
    if (x(ids[k - 1]) == x(ids[k]))
    {
      finding.First = finding.Count == 0 ? ids[k] : std::min<std::int64_t>(finding.First, ids[k]);
      ++finding.Count;
    }
  }
  return finding;
}

std::array<Index, 3> SortedCorners(const TriangleMesh& mesh, std::int64_t f)
{
  std::array<Index, 3> corners = { mesh.Triangles(f, 0), mesh.Triangles(f, 1), mesh.Triangles(f, 2) };
  std::sort(corners.begin(), corners.end());
  return corners;
}

MeshFinding FindDuplicateTriangles(const ProperTriangles& proper, const MeshTopology& topology)
{
  const auto hasEarlierTwin = [&](std::int64_t f) {
    const auto corners = SortedCorners(proper.Mesh, f);
    const auto valence = [&](Index v) { return topology.VertexTriangleStart[v + 1] - topology.VertexTriangleStart[v]; };
    // Of the three corners that a twin would share, the one with the fewest triangles: poles may have very many.
    const Index v = *std::min_element(
      corners.begin(), corners.end(), [&](Index a, Index b) { return valence(a) < valence(b); });
    const Index* first = topology.VertexTriangles.data() + topology.VertexTriangleStart[v];
    const Index* last = topology.VertexTriangles.data() + topology.VertexTriangleStart[v + 1];
    return std::any_of(first, last, [&](Index g) { return g < f && SortedCorners(proper.Mesh, g) == corners; });
  };
  MeshFinding finding = CountIf(MeshDefect::IndexOutOfRange, proper.Mesh.NumberOfTriangles(), hasEarlierTwin);
  finding.First = finding.Count > 0 ? proper.Original[finding.First] : 0;
  return finding;
}

/// The six times enclosed volume below @p f seen from @p origin.
double SixfoldVolume(const TriangleMesh& mesh, Index f, const Eigen::RowVector3d& origin)
{
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k)
  {
    corners.row(k) = mesh.Points.row(mesh.Triangles(f, k)) - origin;
  }
  return corners.determinant();
}

/// Counts of the components, triangle by triangle.
void CountTriangles(const TriangleMesh& mesh, const std::vector<Index>& componentOf, const SurfacePatches& patches,
  const Eigen::VectorXd& areas, const BoundingBox& box, MeshStatistics& statistics)
{
  const Eigen::RowVector3d origin = (0.5 * box.Lower + 0.5 * box.Upper).transpose();
  std::vector<double> asWound(statistics.Components.size(), 0.0);
  std::vector<double> oriented(statistics.Components.size(), 0.0);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const Index c = componentOf[mesh.Triangles(f, 0)];
    ComponentStatistics& component = statistics.Components[c];
    ++component.Triangles;
    component.Area += areas[f];
    statistics.Area += areas[f];
    component.Orientable = component.Orientable && patches.Orientable[patches.OfTriangle[f]];
    component.ConsistentWinding = component.ConsistentWinding && patches.Sign[f] > 0;
    const double volume = SixfoldVolume(mesh, f, origin) / 6.0;
    asWound[c] += volume;
    oriented[c] += patches.Sign[f] * volume;
  }
  for (std::size_t c = 0; c < asWound.size(); ++c)
  {
    ComponentStatistics& component = statistics.Components[c];
    component.ConsistentWinding = component.ConsistentWinding && component.Orientable;
    const double volume = component.ConsistentWinding ? asWound[c] : std::abs(oriented[c]);
    if (component.Closed && component.Manifold && component.Orientable && std::isfinite(volume))
    {
      component.Volume = volume;
    }
  }
}

/// Marks the components that hold a point or an edge which is not that of a manifold.
void FindNonManifoldComponents(
  const TriangleMesh& mesh, const MeshTopology& topology, const MeshComponents& components, MeshStatistics& statistics)
{
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const auto first = topology.EdgeTriangles.begin() + topology.NeighborStart[v];
    const auto last = topology.EdgeTriangles.begin() + topology.NeighborStart[v + 1];
    const bool manifold = std::all_of(first, last, [](std::uint8_t n) { return n <= 2; }) &&
      HasSingleFan(mesh, topology, v);
    if (!manifold)
    {
      statistics.Components[components.OfVertex[v]].Manifold = false;
    }
  }
}

void FindComponents(const TriangleMesh& mesh, const MeshTopology& topology, MeshStatistics& statistics)
{
  const MeshComponents components = ComputeComponents(
    topology, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.NumberOfPoints())));
  statistics.Components.resize(static_cast<std::size_t>(components.Count));
  for (Index v = mesh.NumberOfPoints() - 1; v >= 0; --v)
  {
    if (components.OfVertex[v] >= 0)
    {
      ++statistics.Components[components.OfVertex[v]].Points;
      statistics.Components[components.OfVertex[v]].FirstPoint = v;
    }
  }
  for (Index c = 0; c < components.Count; ++c)
  {
    statistics.Components[c].EulerCharacteristic = components.EulerCharacteristic[c];
    statistics.Components[c].Closed = components.Closed[c];
  }
  FindNonManifoldComponents(mesh, topology, components, statistics);
  const TriangleAdjacency adjacency(mesh, topology);
  for (const BoundaryLoop& loop : FindBoundaryLoops(mesh, adjacency))
  {
    ++statistics.Components[components.OfVertex[loop.FirstPoint]].BoundaryLoops;
    ++statistics.BoundaryLoops;
    if (loop.Length > statistics.LongestBoundaryLoop && std::isfinite(loop.Length))
    {
      statistics.LongestBoundaryLoop = loop.Length;
      statistics.LongestBoundaryLoopPoint = loop.FirstPoint;
    }
  }
  CountTriangles(
    mesh, components.OfVertex, FindPatches(mesh, adjacency), FiniteAreas(mesh), statistics.Box, statistics);
  for (ComponentStatistics& component : statistics.Components)
  {
    if (component.Manifold && component.Orientable)
    {
      component.Genus = (2 - component.EulerCharacteristic - component.BoundaryLoops) / 2;
    }
  }
}

MeshFinding FindSmallComponents(const std::vector<ComponentStatistics>& components)
{
  std::int64_t largest = 0;
  for (const ComponentStatistics& component : components)
  {
    largest = std::max(largest, component.Triangles);
  }
  MeshFinding finding{ MeshDefect::SeveralComponents };
  for (const ComponentStatistics& component : components)
  {
    if (static_cast<double>(component.Triangles) <
      MeshStatistics::SmallComponentFraction * static_cast<double>(largest))
    {
      finding.First = finding.Count == 0 ? component.FirstPoint : finding.First;
      ++finding.Count;
    }
  }
  return finding;
}

/// Sum of a member over all components; absent when one component has none, or there are no components.
template <typename Value>
std::optional<Value> Sum(
  const std::vector<ComponentStatistics>& components, std::optional<Value> ComponentStatistics::*member)
{
  Value sum = 0;
  for (const ComponentStatistics& component : components)
  {
    if (!(component.*member))
    {
      return {};
    }
    sum += *(component.*member);
  }
  return components.empty() ? std::optional<Value>() : sum;
}

bool All(const std::vector<ComponentStatistics>& components, bool ComponentStatistics::*member)
{
  return std::all_of(
    components.begin(), components.end(), [member](const ComponentStatistics& component) { return component.*member; });
}
} // namespace

bool MeshStatistics::Closed() const
{
  return !this->Components.empty() && All(this->Components, &ComponentStatistics::Closed);
}

bool MeshStatistics::Manifold() const { return All(this->Components, &ComponentStatistics::Manifold); }

bool MeshStatistics::Orientable() const { return All(this->Components, &ComponentStatistics::Orientable); }

bool MeshStatistics::ConsistentWinding() const
{
  return All(this->Components, &ComponentStatistics::ConsistentWinding);
}

std::int64_t MeshStatistics::EulerCharacteristic() const
{
  return std::accumulate(this->Components.begin(), this->Components.end(), std::int64_t(0),
    [](std::int64_t sum, const ComponentStatistics& component) { return sum + component.EulerCharacteristic; });
}

std::optional<std::int64_t> MeshStatistics::Genus() const { return Sum(this->Components, &ComponentStatistics::Genus); }

std::optional<double> MeshStatistics::Volume() const { return Sum(this->Components, &ComponentStatistics::Volume); }

double SurfaceArea(const TriangleMesh& mesh)
{
  double doubleArea = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d a = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
    const Eigen::Vector3d b = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
    doubleArea += a.cross(b).norm();
  }
  return 0.5 * doubleArea;
}

double MeanSideLength(const TriangleMesh& mesh)
{
  double sum = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      sum += (mesh.Points.row(mesh.Triangles(f, k)) - mesh.Points.row(mesh.Triangles(f, (k + 1) % 3))).norm();
    }
  }
  return mesh.NumberOfTriangles() > 0 ? sum / (3.0 * mesh.NumberOfTriangles()) : 0.0;
}

MeshStatistics ComputeMeshStatistics(const TriangleMesh& mesh, const Progress& progress)
{
  MeshStatistics statistics;
  const ProperTriangles proper = KeepProperTriangles(mesh);
  const MeshTopology topology(proper.Mesh);
  Report(progress, 0.15);
  statistics.Points = mesh.NumberOfPoints();
  statistics.Triangles = mesh.NumberOfTriangles();
  statistics.ProperTriangles = proper.Mesh.NumberOfTriangles();
  statistics.Edges = topology.NumberOfEdges();
  statistics.UnreferencedPoints = CountIf(
    MeshDefect::IndexOutOfRange, statistics.Points, [&](std::int64_t v) { return !IsUsed(topology, v); });
  statistics.UsedPoints = statistics.Points - statistics.UnreferencedPoints.Count;
  statistics.Findings = InspectMesh(mesh, proper, topology);
  Report(progress, 0.4);
  statistics.CoincidentPoints = FindCoincidentPoints(proper.Mesh, topology);
  Report(progress, 0.55);
  statistics.DuplicateTriangles = FindDuplicateTriangles(proper, topology);
  statistics.Box = FiniteBox(proper.Mesh);
  Report(progress, 0.65);
  FindComponents(proper.Mesh, topology, statistics);
  statistics.SmallComponents = FindSmallComponents(statistics.Components);
  Report(progress, 0.85);
  statistics.EdgeLength = EdgeLengths(proper.Mesh, topology);
  const TriangleShapes shapes = MeasureTriangles(proper.Mesh, proper.Original);
  statistics.SmallestAngle = shapes.SmallestAngle;
  statistics.LargestAngle = shapes.LargestAngle;
  statistics.AspectRatio = shapes.AspectRatio;
  statistics.NeedleTriangles = shapes.Needles;
  Report(progress, 1.0);
  return statistics;
}

} // namespace surfsynth
