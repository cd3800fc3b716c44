// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TriangleShapes.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
/// @param ids of the values
Distribution Summarize(std::vector<double> values, const std::vector<Index>& ids)
{
  Distribution summary;
  summary.Count = static_cast<std::int64_t>(values.size());
  if (values.empty())
  {
    return summary;
  }
  const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
  summary.Minimum = *smallest;
  summary.Maximum = *largest;
  summary.AtMinimum = ids[smallest - values.begin()];
  summary.AtMaximum = ids[std::find(values.begin(), values.end(), summary.Maximum) - values.begin()];
  const double count = static_cast<double>(values.size());
  for (const double value : values)
  {
    summary.Mean += value / count;
  }
  summary.Mean = std::clamp(summary.Mean, summary.Minimum, summary.Maximum);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  summary.Median = *middle;
  return summary;
}

Eigen::Vector3d Corner(const TriangleMesh& mesh, std::int64_t f, int k)
{
  return mesh.Points.row(mesh.Triangles(f, k)).transpose();
}

bool HasFiniteCorners(const TriangleMesh& mesh, std::int64_t f)
{
  return Corner(mesh, f, 0).allFinite() && Corner(mesh, f, 1).allFinite() && Corner(mesh, f, 2).allFinite();
}

struct Shape
{
  double SmallestAngle;
  double LargestAngle;
  double AspectRatio;
};

Shape Measure(const TriangleMesh& mesh, std::int64_t f)
{
  Eigen::Vector3d edges[3];
  double lengths[3];
  for (int k = 0; k < 3; ++k)
  {
    edges[k] = Corner(mesh, f, (k + 1) % 3) - Corner(mesh, f, k);
    lengths[k] = edges[k].norm();
  }
  const double doubleArea = edges[0].cross(edges[1]).norm();
  Shape shape{ 180.0, 0.0, 0.0 };
  const double degrees = 180.0 / std::acos(-1.0);
  for (int k = 0; k < 3; ++k)
  {
    const double angle = degrees * std::atan2(doubleArea, -edges[k].dot(edges[(k + 2) % 3]));
    shape.SmallestAngle = std::min(shape.SmallestAngle, angle);
    shape.LargestAngle = std::max(shape.LargestAngle, angle);
  }
  const double longest = std::max({ lengths[0], lengths[1], lengths[2] });
  const double perimeter = lengths[0] + lengths[1] + lengths[2];
  shape.AspectRatio = (longest / doubleArea) * perimeter / (2.0 * std::sqrt(3.0));
  return shape;
}
} // namespace

Eigen::VectorXd FiniteAreas(const TriangleMesh& mesh)
{
  Eigen::VectorXd areas(mesh.NumberOfTriangles());
  ParallelFor(mesh.NumberOfTriangles(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      const Eigen::Vector3d a = Corner(mesh, f, 1) - Corner(mesh, f, 0);
      const double area = 0.5 * a.cross(Corner(mesh, f, 2) - Corner(mesh, f, 0)).norm();
      areas[f] = std::isfinite(area) ? area : 0.0;
    }
  });
  return areas;
}

BoundingBox FiniteBox(const TriangleMesh& mesh)
{
  BoundingBox box;
  bool empty = true;
  for (std::int64_t f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::Vector3d point = Corner(mesh, f, k);
      if (point.allFinite())
      {
        box.Lower = empty ? point : box.Lower.cwiseMin(point).eval();
        box.Upper = empty ? point : box.Upper.cwiseMax(point).eval();
        empty = false;
      }
    }
  }
  return box;
}

Distribution EdgeLengths(const TriangleMesh& mesh, const MeshTopology& topology)
{
  std::vector<double> lengths;
  std::vector<Index> ids;
  lengths.reserve(static_cast<std::size_t>(topology.NumberOfEdges()));
  ids.reserve(lengths.capacity());
  for (Index v = 0; v < topology.NumberOfPoints(); ++v)
  {
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      const Index other = topology.Neighbors[k];
      const double length = other > v ? (mesh.Points.row(v) - mesh.Points.row(other)).stableNorm() : -1.0;
      if (length >= 0.0 && std::isfinite(length))
      {
        lengths.push_back(length);
        ids.push_back(v);
      }
    }
  }
  return Summarize(std::move(lengths), ids);
}

TriangleShapes MeasureTriangles(const TriangleMesh& mesh, const std::vector<Index>& ids)
{
  const std::int64_t triangles = mesh.NumberOfTriangles();
  std::vector<Shape> shapes(static_cast<std::size_t>(triangles), Shape{ -1.0, -1.0, -1.0 });
  ParallelFor(triangles, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
    {
      if (HasFiniteCorners(mesh, f) && !IsDegenerateTriangle(mesh, f))
      {
        shapes[f] = Measure(mesh, f);
      }
    }
  });
  std::vector<Index> measured;
  std::vector<double> smallest, largest, aspect;
  MeshFinding needles{ MeshDefect::DegenerateTriangle };
  for (std::int64_t f = 0; f < triangles; ++f)
  {
    if (shapes[f].AspectRatio >= 0.0 && std::isfinite(shapes[f].AspectRatio))
    {
      measured.push_back(ids[f]);
      smallest.push_back(shapes[f].SmallestAngle);
      largest.push_back(shapes[f].LargestAngle);
      aspect.push_back(shapes[f].AspectRatio);
      if (shapes[f].SmallestAngle < MeshStatistics::NeedleAngle)
      {
        needles.First = needles.Count == 0 ? ids[f] : needles.First;
        ++needles.Count;
      }
    }
  }
  return { Summarize(std::move(smallest), measured), Summarize(std::move(largest), measured),
    Summarize(std::move(aspect), measured), needles };
}

} // namespace surfsynth
