// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SeparateSheets.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/HalfEdges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

namespace surfsynth
{

namespace
{
/// For each half-edge the one that it is joined with, which runs along the same edge the other way.
using Partners = std::vector<HalfEdge>;

/// One triangle at an edge, by the angle at which it stands around it.
struct AroundEdge
{
  double Angle;
  bool Enters; ///< a turn in the direction of rising angles enters the solid here
  HalfEdge Half;
};

/// The triangles at an edge in the order of a right-handed turn around it, from its lower to its higher point. Of two
/// at the same angle, the one that leaves the solid comes first: another part begins behind it.
std::vector<AroundEdge> SortAround(const TriangleMesh& mesh, const HalfEdge* begin, const HalfEdge* end)
{
  const Index lower = std::min(StartOf(mesh, *begin), EndOf(mesh, *begin));
  const Index upper = std::max(StartOf(mesh, *begin), EndOf(mesh, *begin));
  const Eigen::Vector3d origin = mesh.Points.row(lower).transpose();
  const Eigen::Vector3d axis = (mesh.Points.row(upper).transpose() - origin).normalized();
  const auto across = [&](HalfEdge h) -> Eigen::Vector3d {
    const Eigen::Vector3d apex = mesh.Points.row(ApexOf(mesh, h)).transpose() - origin;
    return apex - axis * axis.dot(apex);
  };
  const Eigen::Vector3d zero = across(*begin).normalized();
  const Eigen::Vector3d quarter = axis.cross(zero);
  std::vector<AroundEdge> around;
  for (const HalfEdge* h = begin; h != end; ++h)
  {
    // The normal of a triangle that runs forward points in the direction of the turn: the solid lies before it.
    const Eigen::Vector3d direction = across(*h);
    const double angle = h == begin ? 0.0 : std::atan2(direction.dot(quarter), direction.dot(zero));
    around.push_back({ angle, !IsForward(mesh, *h), *h });
  }
  std::sort(around.begin(), around.end(), [](const AroundEdge& a, const AroundEdge& b) {
    return std::tie(a.Angle, a.Enters, a.Half) < std::tie(b.Angle, b.Enters, b.Half);
  });
  return around;
}

/// Joins each triangle through which the turn enters the solid with the one through which it leaves the same part, like
/// brackets: the turn begins where no part is open.
void JoinAround(std::vector<AroundEdge> around, Partners& partners)
{
  std::size_t first = 0;
  int depth = 0;
  int lowest = 0;
  for (std::size_t k = 0; k < around.size(); ++k)
  {
    depth += around[k].Enters ? 1 : -1;
    if (depth < lowest)
    {
      lowest = depth;
      first = k + 1;
    }
  }
  std::rotate(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(first % around.size()), around.end());
  std::vector<HalfEdge> open;
  for (const AroundEdge& triangle : around)
  {
    if (triangle.Enters)
    {
      open.push_back(triangle.Half);
      continue;
    }
    partners[triangle.Half] = open.back();
    partners[open.back()] = triangle.Half;
    open.pop_back();
  }
}

Partners JoinSheets(const TriangleMesh& mesh, const EdgeGroups& edges)
{
  Partners partners(edges.HalfEdges.size());
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    const HalfEdge* h = edges.Begin(e);
    if (edges.Size(e) == 2)
    {
      partners[h[0]] = h[1];
      partners[h[1]] = h[0];
    }
    else
    {
      JoinAround(SortAround(mesh, h, edges.End(e)), partners);
    }
  }
  return partners;
}

/// Gives every fan of triangles at a point an id of its own, and returns the ids of the corners. @p source gets, for
/// each id from the number of points on, the point that it is a copy of.
TriangleMatrix SeparateFans(const TriangleMesh& mesh, const Partners& partners, std::vector<Index>& source)
{
  std::vector<char> hasFan(static_cast<std::size_t>(mesh.NumberOfPoints()), 0);
  TriangleMatrix corners = TriangleMatrix::Constant(mesh.NumberOfTriangles(), 3, -1);
  for (HalfEdge start = 0; start < static_cast<HalfEdge>(partners.size()); ++start)
  {
    if (corners.data()[start] >= 0)
    {
      continue;
    }
    const Index point = StartOf(mesh, start);
    Index id = point;
    if (hasFan[point])
    {
      id = static_cast<Index>(mesh.NumberOfPoints() + static_cast<std::int64_t>(source.size()));
      source.push_back(point);
    }
    hasFan[point] = 1;
    HalfEdge h = start;
    do
    {
      corners.data()[h] = id;
      h = NextInTriangle(partners[h]);
    } while (h != start);
  }
  return corners;
}

/// The points of @p mesh, and copies of the points @p source behind them.
PointMatrix WithCopies(const PointMatrix& points, const std::vector<Index>& source)
{
  PointMatrix all(points.rows() + static_cast<Eigen::Index>(source.size()), 3);
  all.topRows(points.rows()) = points;
  for (std::size_t k = 0; k < source.size(); ++k)
  {
    all.row(points.rows() + static_cast<Eigen::Index>(k)) = points.row(source[k]);
  }
  return all;
}

/// The middle points of the half-edges that are to be split, -1 for the others; their coordinates go behind @p points.
std::vector<Index> SplitSharedEdges(
  const TriangleMesh& mesh, const EdgeGroups& edges, const Partners& partners, PointMatrix& points)
{
  std::vector<Index> middle(edges.HalfEdges.size(), -1);
  std::vector<HalfEdge> split;
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    const HalfEdge kept = *edges.Begin(e);
    for (const HalfEdge* h = edges.Begin(e) + 1; h != edges.End(e); ++h)
    {
      if (*h != partners[kept] && middle[*h] < 0)
      {
        middle[*h] = middle[partners[*h]] = static_cast<Index>(points.rows() + static_cast<std::int64_t>(split.size()));
        split.push_back(*h);
      }
    }
  }
  const Eigen::Index before = points.rows();
  points.conservativeResize(before + static_cast<Eigen::Index>(split.size()), 3);
  for (std::size_t k = 0; k < split.size(); ++k)
  {
    points.row(before + static_cast<Eigen::Index>(k)) = 0.5 *
      (points.row(StartOf(mesh, split[k])) + points.row(EndOf(mesh, split[k])));
  }
  return middle;
}

/// Appends the triangles that @p corners becomes when its edges k with middle[k] >= 0 are split there.
void SplitTriangle(
  const std::array<Index, 3>& corners, const std::array<Index, 3>& middle, std::vector<std::array<Index, 3>>& triangles)
{
  const auto splits = std::count_if(middle.begin(), middle.end(), [](Index m) { return m >= 0; });
  int k = 0; // the split edge, of two the first, of all any
  while (splits > 0 && !(middle[k] >= 0 && (splits != 2 || middle[(k + 1) % 3] >= 0)))
  {
    ++k;
  }
  const Index a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
  const Index ab = middle[k], bc = middle[(k + 1) % 3], ca = middle[(k + 2) % 3];
  switch (splits)
  {
    case 0:
      triangles.push_back(corners);
      break;
    case 1:
      triangles.insert(triangles.end(), { { a, ab, c }, { ab, b, c } });
      break;
    case 2:
      triangles.insert(triangles.end(), { { ab, b, bc }, { a, ab, bc }, { a, bc, c } });
      break;
    default:
      triangles.insert(triangles.end(), { { a, ab, ca }, { b, bc, ab }, { c, ca, bc }, { ab, bc, ca } });
  }
}

TriangleMesh SplitTriangles(const TriangleMesh& mesh, const std::vector<Index>& middle, PointMatrix points)
{
  std::vector<std::array<Index, 3>> triangles;
  triangles.reserve(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  for (std::size_t f = 0; f < static_cast<std::size_t>(mesh.NumberOfTriangles()); ++f)
  {
    const auto t = mesh.Triangles.row(static_cast<Eigen::Index>(f));
    SplitTriangle({ t(0), t(1), t(2) }, { middle[3 * f], middle[3 * f + 1], middle[3 * f + 2] }, triangles);
  }
  TriangleMesh result;
  result.Points = std::move(points);
  result.Triangles = Eigen::Map<const TriangleMatrix>(
    triangles.front().data(), static_cast<Eigen::Index>(triangles.size()), 3);
  return result;
}

bool HasSharedEdge(const EdgeGroups& edges)
{
  for (std::int64_t e = 0; e < edges.NumberOfEdges(); ++e)
  {
    if (edges.Size(e) > 2)
    {
      return true;
    }
  }
  return false;
}
} // namespace

TriangleMesh SeparateSheets(const TriangleMesh& mesh)
{
  MeshWithEdges clean = WithoutFlatPairs(mesh);
  TriangleMesh& result = clean.Mesh;
  const EdgeGroups& edges = clean.Edges;
  if (result.NumberOfTriangles() == 0)
  {
    return result;
  }
  RequireBalanced(result, edges, "SeparateSheets");
  const Partners partners = JoinSheets(result, edges);
  std::vector<Index> source;
  result.Triangles = SeparateFans(result, partners, source);
  if (result.Points.rows() + static_cast<std::int64_t>(source.size()) > std::numeric_limits<Index>::max() / 2)
  {
    throw InvalidInput("SeparateSheets: the mesh has " + std::to_string(result.Points.rows()) +
      " points; at most 1073741823 are allowed.");
  }
  result.Points = WithCopies(result.Points, source);
  if (!HasSharedEdge(edges))
  {
    return result;
  }
  PointMatrix points = result.Points;
  const std::vector<Index> middle = SplitSharedEdges(result, EdgeGroups(result), partners, points);
  return points.rows() == result.Points.rows() ? result : SplitTriangles(result, middle, std::move(points));
}

} // namespace surfsynth
