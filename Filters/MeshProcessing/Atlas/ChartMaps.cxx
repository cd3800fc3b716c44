// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Atlas/ChartMaps.h"

#include "MeshProcessing/Cgal/CgalMesh.h"

#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Surface_mesh_approximation/L21_metric_plane_proxy.h>
#include <CGAL/Surface_mesh_parameterization/LSCM_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/parameterize.h>
#include <CGAL/Variational_shape_approximation.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace surfsynth
{

namespace
{
/// Ratio to the error of a single part at which no more parts are added.
constexpr double ErrorDrop = 0.2;
constexpr std::size_t NumberOfIterations = 8;

double SignedArea(const FlatPoints& flat, const Index* t)
{
  const Eigen::RowVector2d a = flat.row(t[1]) - flat.row(t[0]);
  const Eigen::RowVector2d b = flat.row(t[2]) - flat.row(t[0]);
  return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

double Area(const TriangleMesh& mesh, Index f)
{
  const auto t = mesh.Triangles.row(f);
  const Eigen::RowVector3d a = mesh.Points.row(t(1)) - mesh.Points.row(t(0));
  const Eigen::RowVector3d b = mesh.Points.row(t(2)) - mesh.Points.row(t(0));
  return 0.5 * a.cross(b).norm();
}

/// The half-edge with the outside on its left; the chart has a boundary.
CgalHalfedge BorderOf(const CgalMesh& mesh)
{
  return *std::find_if(
    mesh.halfedges().begin(), mesh.halfedges().end(), [&](CgalHalfedge h) { return mesh.is_border(h); });
}

/// Scales @p flat to the area of the chart; empty when a triangle is flipped or the outline crosses itself. A disk whose
/// triangles are all wound alike and whose outline does not cross itself does not overlap itself.
FlatPoints Accepted(const TriangleMesh& disk, const CgalMesh& mesh, FlatPoints flat)
{
  if (!flat.allFinite())
  {
    return {};
  }
  double flatArea = 0.0;
  double area = 0.0;
  for (Index f = 0; f < disk.NumberOfTriangles(); ++f)
  {
    const double signedArea = SignedArea(flat, disk.Triangles.row(f).data());
    if (!(signedArea > 0.0))
    {
      return {};
    }
    flatArea += signedArea;
    area += Area(disk, f);
  }
  std::vector<CgalKernel::Point_2> outline;
  const CgalHalfedge first = BorderOf(mesh);
  CgalHalfedge h = first;
  do
  {
    const auto v = static_cast<Eigen::Index>(mesh.target(h).idx());
    outline.emplace_back(flat(v, 0), flat(v, 1));
    h = mesh.next(h);
  } while (h != first);
  if (!CGAL::is_simple_2(outline.begin(), outline.end(), CgalKernel()))
  {
    return {};
  }
  return flat * std::sqrt(area / flatArea);
}
} // namespace

std::vector<std::size_t> HalveChart(const TriangleMesh& chart)
{
  const BoundingBox box = ComputeBoundingBox(chart);
  Eigen::Index axis = 0;
  (box.Upper - box.Lower).maxCoeff(&axis);
  const auto center = [&](Index f) {
    return chart.Points(chart.Triangles(f, 0), axis) + chart.Points(chart.Triangles(f, 1), axis) +
      chart.Points(chart.Triangles(f, 2), axis);
  };
  std::vector<Index> order(static_cast<std::size_t>(chart.NumberOfTriangles()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index f, Index g) { return center(f) < center(g); });
  std::vector<std::size_t> labels(order.size(), 0);
  for (std::size_t k = 0; k < order.size() / 2; ++k)
  {
    labels[order[k]] = 1;
  }
  return labels;
}

std::vector<std::size_t> DivideChart(const TriangleMesh& chart, std::size_t maximumParts)
{
  using Metric = CGAL::Surface_mesh_approximation::L21_metric_plane_proxy<CgalMesh>;
  using PointMap = CgalMesh::Property_map<CgalVertex, CgalPoint>;
  const auto triangles = static_cast<std::size_t>(chart.NumberOfTriangles());
  if (maximumParts >= triangles / 3) // fewer triangles than CGAL divides
  {
    return HalveChart(chart);
  }
  CgalMesh mesh = ToCgalMesh(chart);
  const Metric metric(mesh, mesh.points());
  CGAL::Variational_shape_approximation<CgalMesh, PointMap, Metric> approximation(mesh, mesh.points(), metric);
  const auto options = CGAL::parameters::seeding_method(CGAL::Surface_mesh_approximation::HIERARCHICAL)
                         .max_number_of_proxies(maximumParts);
  if (maximumParts > 2)
  {
    approximation.initialize_seeds(options.min_error_drop(ErrorDrop));
  }
  else
  {
    approximation.initialize_seeds(options);
  }
  approximation.run(NumberOfIterations);
  const auto proxies = mesh.add_property_map<CgalFace, std::size_t>("f:proxy", 0).first;
  approximation.proxy_map(proxies);
  std::vector<std::size_t> labels(triangles);
  std::transform(
    mesh.faces().begin(), mesh.faces().end(), labels.begin(), [&](CgalFace face) { return proxies[face]; });
  return std::set<std::size_t>(labels.begin(), labels.end()).size() > 1 ? labels : HalveChart(chart);
}

FlatPoints FlattenConformally(const TriangleMesh& disk)
{
  namespace Parameterization = CGAL::Surface_mesh_parameterization;
  CgalMesh mesh = ToCgalMesh(disk);
  const auto flat = mesh.add_property_map<CgalVertex, CgalKernel::Point_2>("v:flat").first;
  const auto error = Parameterization::parameterize(
    mesh, Parameterization::LSCM_parameterizer_3<CgalMesh>(), BorderOf(mesh), flat);
  if (error != Parameterization::OK)
  {
    return {};
  }
  FlatPoints points(disk.NumberOfPoints(), 2);
  for (const CgalVertex v : mesh.vertices())
  {
    points.row(static_cast<Eigen::Index>(v.idx())) << flat[v].x(), flat[v].y();
  }
  if (SignedArea(points, disk.Triangles.row(0).data()) < 0.0)
  {
    points.col(0) *= -1.0; // the two fixed points leave the orientation open
  }
  return Accepted(disk, mesh, std::move(points));
}

FlatPoints FlattenByProjection(const TriangleMesh& disk)
{
  Eigen::RowVector3d normal = Eigen::RowVector3d::Zero();
  for (Index f = 0; f < disk.NumberOfTriangles(); ++f)
  {
    const auto t = disk.Triangles.row(f);
    const Eigen::RowVector3d a = disk.Points.row(t(1)) - disk.Points.row(t(0));
    const Eigen::RowVector3d b = disk.Points.row(t(2)) - disk.Points.row(t(0));
    normal += a.cross(b);
  }
  normal.normalize();
  const Eigen::RowVector3d x = normal.unitOrthogonal();
  const Eigen::RowVector3d y = normal.cross(x);
  FlatPoints points(disk.NumberOfPoints(), 2);
  points.col(0) = disk.Points * x.transpose();
  points.col(1) = disk.Points * y.transpose();
  return Accepted(disk, ToCgalMesh(disk), std::move(points));
}

ChartStretch MeasureStretch(const TriangleMesh& chart, const FlatPoints& flat)
{
  ChartStretch stretch;
  for (Index f = 0; f < chart.NumberOfTriangles(); ++f)
  {
    const auto t = chart.Triangles.row(f);
    Eigen::Matrix2d from;
    from.col(0) = (flat.row(t(1)) - flat.row(t(0))).transpose();
    from.col(1) = (flat.row(t(2)) - flat.row(t(0))).transpose();
    Eigen::Matrix<double, 3, 2> to;
    to.col(0) = (chart.Points.row(t(1)) - chart.Points.row(t(0))).transpose();
    to.col(1) = (chart.Points.row(t(2)) - chart.Points.row(t(0))).transpose();
    // The eigenvalues of J^T J are S^2 and s^2, with J the derivative of the surface by the texture.
    const Eigen::Matrix<double, 3, 2> jacobian = to * from.inverse();
    const double a = jacobian.col(0).squaredNorm();
    const double b = jacobian.col(0).dot(jacobian.col(1));
    const double c = jacobian.col(1).squaredNorm();
    const double mean = 0.5 * (a + c);
    const double largest = mean + std::hypot(0.5 * (a - c), b);
    const double smallest = jacobian.col(0).cross(jacobian.col(1)).squaredNorm() / largest;
    const double area = Area(chart, f);
    stretch.Area += area;
    stretch.SquaredStretch += area * mean;
    stretch.Largest = std::max({ stretch.Largest, std::sqrt(largest), 1.0 / std::sqrt(smallest) });
  }
  return stretch;
}

} // namespace surfsynth
