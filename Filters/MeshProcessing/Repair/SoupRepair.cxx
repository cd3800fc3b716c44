// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/SoupRepair.h"

#include "MeshProcessing/Cgal/CgalMesh.h"

#include "Core/Mesh/PointCloud.h"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>

#include <Eigen/Geometry>
#include <nanoflann.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace surfsynth
{

namespace
{
/// Keeps the triangles for which @p keep(f) holds. @return number of those dropped
template <typename Predicate>
std::int64_t KeepTriangles(Soup& soup, const Predicate& keep)
{
  TriangleMatrix& triangles = soup.Mesh.Triangles;
  Index kept = 0;
  for (Index f = 0; f < triangles.rows(); ++f)
  {
    if (keep(f))
    {
      triangles.row(kept) = triangles.row(f).eval();
      soup.OriginOfTriangle[kept++] = soup.OriginOfTriangle[f];
    }
  }
  const std::int64_t dropped = triangles.rows() - kept;
  triangles.conservativeResize(kept, 3);
  soup.OriginOfTriangle.resize(kept);
  return dropped;
}

/// Target of the merge for each point: in the order of their ids, points that are still there take those within
/// @p tolerance.
std::vector<Index> MergeMap(const PointMatrix& points, double tolerance)
{
  if (!(tolerance > 0.0) || points.rows() == 0)
  {
    return EqualPoints(points);
  }
  using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>, PointCloud, 3, std::uint32_t>;
  const PointCloud cloud{ points };
  Tree tree(3, cloud);
  tree.buildIndex();
  const double within = std::nextafter(tolerance * tolerance, std::numeric_limits<double>::infinity());
  std::vector<Index> map(static_cast<std::size_t>(points.rows()), -1);
  std::vector<std::pair<std::uint32_t, double>> found;
  for (Index p = 0; p < static_cast<Index>(map.size()); ++p)
  {
    if (map[p] >= 0)
    {
      continue;
    }
    tree.radiusSearch(points.row(p).data(), within, found, nanoflann::SearchParams());
    map[p] = p;
    for (const auto& [other, distance] : found)
    {
      map[other] = map[other] < 0 ? p : map[other];
    }
  }
  return map;
}

/// The parts of a mesh that are connected through points; a number for each triangle.
std::vector<Index> ConnectedParts(const TriangleMatrix& triangles, Index points)
{
  std::vector<Index> root(static_cast<std::size_t>(points));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](Index v) {
    while (root[v] != v)
    {
      v = root[v] = root[root[v]];
    }
    return v;
  };
  for (Index f = 0; f < triangles.rows(); ++f)
  {
    root[find(triangles(f, 1))] = find(triangles(f, 0));
    root[find(triangles(f, 2))] = find(triangles(f, 0));
  }
  std::vector<Index> part(static_cast<std::size_t>(triangles.rows()));
  for (Index f = 0; f < triangles.rows(); ++f)
  {
    part[f] = find(triangles(f, 0));
  }
  return part;
}

double DoubleArea(const TriangleMesh& mesh, Index f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::Vector3d a = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
  const Eigen::Vector3d b = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
  return a.cross(b).norm();
}

/// Reverses the parts of which the larger area was reversed. @return number of triangles that stay reversed
std::int64_t RestoreWinding(TriangleMesh& mesh, const std::vector<bool>& isTurned)
{
  const std::vector<Index> part = ConnectedParts(mesh.Triangles, mesh.NumberOfPoints());
  std::map<Index, double> balance; // area turned minus area kept
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    balance[part[f]] += isTurned[f] ? DoubleArea(mesh, f) : -DoubleArea(mesh, f);
  }
  std::int64_t turned = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const bool turnBack = balance[part[f]] > 0.0;
    if (turnBack)
    {
      std::swap(mesh.Triangles(f, 1), mesh.Triangles(f, 2));
    }
    turned += isTurned[f] != turnBack ? 1 : 0;
  }
  return turned;
}

/// Record of the triangles that CGAL has reversed.
struct TurnRecorder : CGAL::Polygon_mesh_processing::Default_orientation_visitor
{
  explicit TurnRecorder(std::vector<bool>* isTurned)
    : IsTurned(isTurned)
  {}
  void polygon_orientation_reversed(std::size_t f) { (*this->IsTurned)[f] = !(*this->IsTurned)[f]; }

  std::vector<bool>* IsTurned;
};
} // namespace

std::vector<Index> EqualPoints(const PointMatrix& points)
{
  std::vector<Index> map(static_cast<std::size_t>(points.rows()));
  std::iota(map.begin(), map.end(), 0);
  std::vector<Index> order;
  order.reserve(map.size());
  std::copy_if(map.begin(), map.end(), std::back_inserter(order), [&](Index p) { return points.row(p).allFinite(); });
  const auto key = [&](Index p) { return std::make_tuple(points(p, 0), points(p, 1), points(p, 2)); };
  std::sort(order.begin(), order.end(),
    [&](Index a, Index b) { return std::make_tuple(key(a), a) < std::make_tuple(key(b), b); });
  for (std::size_t k = 1; k < order.size(); ++k)
  {
    map[order[k]] = key(order[k - 1]) == key(order[k]) ? map[order[k - 1]] : order[k];
  }
  return map;
}

std::int64_t MergePoints(Soup& soup, double tolerance)
{
  const std::vector<Index> map = MergeMap(soup.Mesh.Points, tolerance);
  std::vector<bool> isUsed(map.size(), false);
  std::int64_t merged = 0;
  for (Index* id = soup.Mesh.Triangles.data(); id != soup.Mesh.Triangles.data() + soup.Mesh.Triangles.size(); ++id)
  {
    merged += map[*id] != *id && !isUsed[*id] ? 1 : 0;
    isUsed[*id] = true;
    *id = map[*id];
  }
  const TriangleMatrix& t = soup.Mesh.Triangles;
  KeepTriangles(soup, [&](Index f) { return t(f, 0) != t(f, 1) && t(f, 1) != t(f, 2) && t(f, 2) != t(f, 0); });
  return merged;
}

std::int64_t RemoveDuplicateTriangles(Soup& soup)
{
  std::vector<std::array<Index, 4>> keys(static_cast<std::size_t>(soup.Mesh.Triangles.rows()));
  for (Index f = 0; f < soup.Mesh.Triangles.rows(); ++f)
  {
    keys[f] = { soup.Mesh.Triangles(f, 0), soup.Mesh.Triangles(f, 1), soup.Mesh.Triangles(f, 2), f };
    std::sort(keys[f].begin(), keys[f].begin() + 3);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> isFirst(keys.size(), true);
  for (std::size_t k = 1; k < keys.size(); ++k)
  {
    isFirst[keys[k][3]] = !std::equal(keys[k].begin(), keys[k].begin() + 3, keys[k - 1].begin());
  }
  return KeepTriangles(soup, [&](Index f) { return isFirst[f]; });
}

ManifoldChanges MakeManifold(Soup& soup)
{
  TriangleMesh& mesh = soup.Mesh;
  std::vector<CgalPoint> points;
  points.reserve(static_cast<std::size_t>(mesh.NumberOfPoints()));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    points.push_back(ToCgalPoint(mesh.Points.row(v).transpose()));
  }
  std::vector<std::array<std::size_t, 3>> triangles(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    std::copy_n(mesh.Triangles.row(f).data(), 3, triangles[f].begin());
  }
  std::vector<bool> isTurned(triangles.size(), false);
  CGAL::Polygon_mesh_processing::orient_polygon_soup(
    points, triangles, CGAL::parameters::visitor(TurnRecorder(&isTurned)));
  const Index before = mesh.NumberOfPoints();
  mesh.Points.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
  {
    mesh.Points.row(static_cast<Eigen::Index>(v)) = FromCgalPoint(points[v]).transpose();
  }
  for (std::size_t f = 0; f < triangles.size(); ++f)
  {
    std::transform(triangles[f].begin(), triangles[f].end(), mesh.Triangles.row(static_cast<Eigen::Index>(f)).data(),
      [](std::size_t id) { return static_cast<Index>(id); });
  }
  ManifoldChanges changes;
  changes.AddedPoints = mesh.NumberOfPoints() - before;
  changes.FlippedTriangles = RestoreWinding(mesh, isTurned);
  return changes;
}

} // namespace surfsynth
