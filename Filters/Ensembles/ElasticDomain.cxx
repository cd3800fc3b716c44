// SPDX-License-Identifier: BSD-3-Clause
#include "ElasticDomain.h"

#include "VolumeBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/UsedPoints.h"

#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"
#endif

#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/Dense>

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace surfsynth
{

namespace
{
/// Without the points that no tetrahedron uses.
TetrahedralMesh Compact(const TetrahedralMesh& mesh)
{
  std::vector<Index> place(static_cast<std::size_t>(mesh.NumberOfPoints()), -1);
  for (Eigen::Index k = 0; k < mesh.Tetrahedra.size(); ++k)
  {
    place[mesh.Tetrahedra.data()[k]] = 0;
  }
  TetrahedralMesh compact{ PointMatrix(mesh.NumberOfPoints(), 3), mesh.Tetrahedra };
  Index count = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (place[v] == 0)
    {
      compact.Points.row(count) = mesh.Points.row(v);
      place[v] = count++;
    }
  }
  compact.Points.conservativeResize(count, 3);
  for (Eigen::Index k = 0; k < compact.Tetrahedra.size(); ++k)
  {
    compact.Tetrahedra.data()[k] = place[compact.Tetrahedra.data()[k]];
  }
  return compact;
}

/// Barycentric coordinates of @p point in tetrahedron @p t, below 0 outside.
Eigen::Vector4d WeightsIn(const TetrahedralMesh& mesh, Index t, const Eigen::Vector3d& point)
{
  Eigen::Matrix3d edges;
  const Eigen::Vector3d first = mesh.Points.row(mesh.Tetrahedra(t, 0)).transpose();
  for (int k = 0; k < 3; ++k)
  {
    edges.col(k) = mesh.Points.row(mesh.Tetrahedra(t, k + 1)).transpose() - first;
  }
  const Eigen::Vector3d others = edges.inverse() * (point - first);
  return Eigen::Vector4d(1.0 - others.sum(), others[0], others[1], others[2]);
}

PointMatrix CoordinatesOf(vtkPointSet* set)
{
  PointMatrix points(set->GetNumberOfPoints(), 3);
  for (vtkIdType p = 0; p < set->GetNumberOfPoints(); ++p)
  {
    set->GetPoint(p, points.data() + 3 * p);
  }
  return points;
}

/// Binds the points to the tetrahedra that are nearest to them.
void Bind(ElasticDomain& domain)
{
  const PointMatrix finite = domain.Points.unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  const std::vector<VolumePlace> places = FindNearestPlaces(domain.Mesh, finite);
  for (Eigen::Index v = 0; v < domain.Points.rows(); ++v)
  {
    const Index t = places[static_cast<std::size_t>(v)].Tetrahedron;
    const auto row = domain.Mesh.Tetrahedra.row(t);
    const bool isFinite = domain.Points.row(v).allFinite();
    domain.Corners.push_back({ isFinite ? row[0] : -1, row[1], row[2], row[3] });
    domain.Weights.push_back(WeightsIn(domain.Mesh, t, finite.row(v).transpose()));
  }
}

#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
/// The surface with so many points, evenly spread.
TriangleMesh Remeshed(const TriangleMesh& mesh, int points, const Progress& progress)
{
  const auto result = std::make_shared<TriangleMesh>();
  RemeshingOptions options;
  options.NumberOfPoints = points;
  options.FindPlaces = false;
  options.FindOrigins = false;
  const auto work = [result, mesh, options](
                      const std::atomic<bool>& stop) { *result = RemeshIsotropically(mesh, options, &stop).Mesh; };
  RunCancellable(work, 0.5 + 1e-5 * mesh.NumberOfPoints(), progress);
  return std::move(*result);
}

TetrahedralMesh Filled(vtkPolyData* input, int surfacePoints, const Progress& progress)
{
  MeshRequirements requirements;
  requirements.Closed = true;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  const Surface surface = ToSurface(input, requirements);
  TriangleMesh mesh = UsedPoints(surface.Mesh).Compact(surface.Mesh);
  TetrahedralizeOptions options;
  std::function<std::int64_t(std::int64_t)> cellOfTriangle = [&surface](std::int64_t f) { return surface.Cell(f); };
  if (surfacePoints > 0)
  {
    mesh = Remeshed(mesh, surfacePoints, SubProgress(progress, 0.0, 0.5));
    cellOfTriangle = {};
  }
  options.TargetEdgeLength = MeanEdgeLength(mesh);
  const FilledSurface filled = Tetrahedralize(mesh, options, cellOfTriangle, SubProgress(progress, 0.5, 1.0));
  return { filled.Points, filled.Tetrahedra };
}
#else
TetrahedralMesh Filled(vtkPolyData*, int, const Progress&)
{
  throw InvalidInput("A surface is to be filled with tetrahedra, but the library was built without CGAL or TetGen; "
                     "expected tetrahedra at port 1 (SetTetrahedraConnection).");
}
#endif
} // namespace

PointMatrix ElasticDomain::Follow(const PointMatrix& nodes) const
{
  PointMatrix points = this->Points;
  for (std::size_t v = 0; v < this->Corners.size(); ++v)
  {
    if (this->Corners[v][0] >= 0)
    {
      Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
      for (std::size_t corner = 0; corner < 4; ++corner)
      {
        point += this->Weights[v][static_cast<Eigen::Index>(corner)] * nodes.row(this->Corners[v][corner]);
      }
      points.row(static_cast<Eigen::Index>(v)) = point;
    }
  }
  return points;
}

TetrahedralMesh TetrahedraOf(vtkUnstructuredGrid* grid)
{
  const Surface volume = ConvertVolume(grid);
  RequireValidVolume(*volume.Volume, [&volume](std::int64_t t) { return volume.Cell(t); });
  return Compact(*volume.Volume);
}

ElasticDomain MakeElasticDomain(
  vtkDataObject* input, const TetrahedralMesh* tetrahedra, int surfacePoints, const Progress& progress)
{
  ElasticDomain domain;
  auto* grid = vtkUnstructuredGrid::SafeDownCast(input);
  if (grid && !IsVolume(grid))
  {
    throw InvalidInput("The vtkUnstructuredGrid has no tetrahedron; expected tetrahedra, or a vtkPolyData.");
  }
  if (grid)
  {
    domain.Mesh = TetrahedraOf(grid);
  }
  else
  {
    domain.Mesh = tetrahedra ? *tetrahedra
                             : Filled(vtkPolyData::SafeDownCast(input), surfacePoints, SubProgress(progress, 0.0, 0.9));
  }
  domain.Points = CoordinatesOf(vtkPointSet::SafeDownCast(input));
  Bind(domain);
  Report(progress, 1.0);
  return domain;
}

} // namespace surfsynth
