// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/EdgeSplits.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/HalfEdges.h"

#include <array>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
constexpr Index None = -1;

/// The midpoint on each half-edge, [3 F], or None; adds the points and their parents.
std::vector<Index> PlaceMidpoints(
  const TriangleMesh& mesh, const std::function<bool(std::int64_t)>& isSplit, SubdividedMesh& result)
{
  const EdgeGroups edges(mesh);
  std::vector<Index> midpoints(3 * static_cast<std::size_t>(mesh.NumberOfTriangles()), None);
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    if (!isSplit(e))
    {
      continue;
    }
    const std::int64_t midpoint = mesh.NumberOfPoints() + static_cast<std::int64_t>(result.Parents.size());
    if (midpoint >= std::numeric_limits<Index>::max())
    {
      throw InvalidInput("SplitEdges: the result would have more than 2147483647 vertices; expected fewer splits.");
    }
    const HalfEdge first = *edges.Begin(e);
    result.Parents.push_back({ StartOf(mesh, first), EndOf(mesh, first) });
    for (const HalfEdge* h = edges.Begin(e); h != edges.End(e); ++h)
    {
      midpoints[*h] = static_cast<Index>(midpoint);
    }
  }
  return midpoints;
}

/// A triangle and the midpoints of its edges: Midpoints[k] lies between Corners[k] and Corners[k + 1], None where that edge
/// is not split.
struct SplitTriangle
{
  std::array<Index, 3> Corners;
  std::array<Index, 3> Midpoints;

  int Splits() const
  {
    return (this->Midpoints[0] != None) + (this->Midpoints[1] != None) + (this->Midpoints[2] != None);
  }
  /// Begins with another corner.
  SplitTriangle From(int corner) const
  {
    const int a = corner, b = (corner + 1) % 3, c = (corner + 2) % 3;
    return { { this->Corners[a], this->Corners[b], this->Corners[c] },
      { this->Midpoints[a], this->Midpoints[b], this->Midpoints[c] } };
  }
};

using Triangles = std::vector<std::array<Index, 3>>;

void AddQuadrangle(const PointMatrix& points, const std::array<Index, 4>& q, Triangles& out)
{
  const auto length = [&](int a, int b) { return (points.row(q[a]) - points.row(q[b])).squaredNorm(); };
  if (length(0, 2) <= length(1, 3))
  {
    out.push_back({ q[0], q[1], q[2] });
    out.push_back({ q[0], q[2], q[3] });
  }
  else
  {
    out.push_back({ q[0], q[1], q[3] });
    out.push_back({ q[1], q[2], q[3] });
  }
}

void AddParts(const PointMatrix& points, const SplitTriangle& whole, Triangles& out)
{
  switch (whole.Splits())
  {
    case 0:
      out.push_back(whole.Corners);
      return;
    case 1:
    {
      const SplitTriangle t = whole.From(whole.Midpoints[0] != None ? 0 : whole.Midpoints[1] != None ? 1 : 2);
      out.push_back({ t.Corners[0], t.Midpoints[0], t.Corners[2] });
      out.push_back({ t.Midpoints[0], t.Corners[1], t.Corners[2] });
      return;
    }
    case 2:
    {
      const SplitTriangle t = whole.From(whole.Midpoints[2] == None ? 0 : whole.Midpoints[0] == None ? 1 : 2);
      out.push_back({ t.Corners[1], t.Midpoints[1], t.Midpoints[0] });
      AddQuadrangle(points, { t.Corners[0], t.Midpoints[0], t.Midpoints[1], t.Corners[2] }, out);
      return;
    }
    default:
      out.push_back({ whole.Corners[0], whole.Midpoints[0], whole.Midpoints[2] });
      out.push_back({ whole.Corners[1], whole.Midpoints[1], whole.Midpoints[0] });
      out.push_back({ whole.Corners[2], whole.Midpoints[2], whole.Midpoints[1] });
      out.push_back(whole.Midpoints);
  }
}
} // namespace

SubdividedMesh SplitEdges(const TriangleMesh& mesh, const std::function<bool(std::int64_t edge)>& isSplit)
{
  SubdividedMesh result;
  const std::vector<Index> midpoints = PlaceMidpoints(mesh, isSplit, result);
  result.Mesh.Points = InterpolateAtMidpoints(mesh.Points, result.Parents);
  Triangles triangles;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto v = mesh.Triangles.row(f);
    const Index* m = midpoints.data() + 3 * static_cast<std::size_t>(f);
    AddParts(result.Mesh.Points, { { v(0), v(1), v(2) }, { m[0], m[1], m[2] } }, triangles);
    if (triangles.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max()))
    {
      throw InvalidInput("SplitEdges: the result would have more than 2147483647 triangles; expected fewer splits.");
    }
  }
  result.Mesh.Triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t k = 0; k < triangles.size(); ++k)
  {
    result.Mesh.Triangles.row(static_cast<Eigen::Index>(k)) << triangles[k][0], triangles[k][1], triangles[k][2];
  }
  return result;
}

} // namespace surfsynth
