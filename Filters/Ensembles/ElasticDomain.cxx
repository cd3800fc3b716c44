// SPDX-License-Identifier: BSD-3-Clause
#include "ElasticDomain.h"

#include "VolumeBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/UsedPoints.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Operators/VolumeOperators.h"

#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"
#endif

#include <Eigen/Dense>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
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

/// The rotation nearest to the deformation of tetrahedron @p t.
Eigen::Matrix3d RotationOf(const TetrahedralMesh& mesh, const PointMatrix& nodes, Index t)
{
  const Eigen::Matrix3d before = EdgesFromFirstCorner(mesh.Points, mesh.Tetrahedra, t);
  const Eigen::Matrix3d gradient = EdgesFromFirstCorner(nodes, mesh.Tetrahedra, t) * before.inverse();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose(); // no reflection: tetrahedra do not turn over
}

/// Binds the points to the tetrahedra that are nearest to them.
void Bind(ElasticDomain& domain)
{
  const PointMatrix finite = domain.Points.unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  domain.Places = FindNearestPlaces(domain.Mesh, finite);
  domain.Offsets.resize(finite.rows(), 3);
  for (Eigen::Index v = 0; v < finite.rows(); ++v)
  {
    VolumePlace& place = domain.Places[static_cast<std::size_t>(v)];
    domain.Offsets.row(v) = finite.row(v) - PositionOf(domain.Mesh, place).transpose();
    place.Tetrahedron = domain.Points.row(v).allFinite() ? place.Tetrahedron : -1;
  }
}

#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
/// Numbers of points with which a surface is remeshed at most, each a quarter of the first larger than the one before.
constexpr int Attempts = 3;

/// The surface with so many points, evenly spread.
TriangleMesh Remeshed(const TriangleMesh& mesh, int points, const Progress& progress)
{
  const auto result = std::make_shared<TriangleMesh>();
  RemeshingOptions options;
  options.EdgeLength = MeanSideLength(mesh);
  options.NumberOfPoints = points;
  options.FindPlaces = false;
  options.FindOrigins = false;
  const auto work = [result, mesh, options](
                      const std::atomic<bool>& stop) { *result = RemeshIsotropically(mesh, options, &stop).Mesh; };
  RunCancellable(work, 0.5 + 1e-5 * mesh.NumberOfPoints(), progress);
  return std::move(*result);
}

/// Tetrahedra in a surface that is remeshed to so many points. Coarse triangles on both sides of a thin part may meet:
/// then with more of them. TetGen's reasons are about triangles and options that the caller does not know.
FilledSurface FillRemeshed(const TriangleMesh& surface, int points, const Progress& progress)
{
  for (int attempt = 0; attempt < Attempts; ++attempt)
  {
    const Progress attempting = SubProgress(progress, attempt / double{ Attempts }, (attempt + 1) / double{ Attempts });
    const auto morePoints = static_cast<int>(std::min(points * (1.0 + 0.25 * attempt), 1e9));
    const TriangleMesh mesh = Remeshed(surface, morePoints, SubProgress(attempting, 0.0, 0.5));
    TetrahedralizeOptions options;
    options.TargetEdgeLength = MeanSideLength(mesh);
    try
    {
      return Tetrahedralize(mesh, options, {}, SubProgress(attempting, 0.5, 1.0));
    }
    catch (const InvalidInput&)
    {}
    catch (const SolverFailure&)
    {}
  }
  throw InvalidInput("The surface, remeshed to " + std::to_string(points) +
    " points (NumberOfSurfacePoints) and up to half as many again, cannot be filled; a number above twice that, 0, or "
    "tetrahedra on port 1 (SetTetrahedraConnection) may help.");
}

TetrahedralMesh Filled(Surface& surface, int surfacePoints, const Progress& progress)
{
  MeshRequirements requirements;
  requirements.Closed = true;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  CheckSurface(surface, requirements);
  const TriangleMesh mesh = UsedPoints(surface.Mesh).Compact(surface.Mesh);
  FilledSurface filled;
  if (surfacePoints > 0)
  {
    filled = FillRemeshed(mesh, surfacePoints, progress);
  }
  else
  {
    const auto cellOfTriangle = [&surface](std::int64_t f) { return surface.Cell(f); };
    TetrahedralizeOptions options;
    options.TargetEdgeLength = MeanSideLength(mesh);
    filled = Tetrahedralize(mesh, options, cellOfTriangle, progress);
  }
  return { filled.Points, filled.Tetrahedra };
}
#else
TetrahedralMesh Filled(Surface&, int, const Progress&)
{
  throw InvalidInput("A surface is to be filled with tetrahedra, but the library was built without CGAL or TetGen; "
                     "expected tetrahedra at port 1 (SetTetrahedraConnection).");
}
#endif
} // namespace

PointMatrix ElasticDomain::Follow(const PointMatrix& nodes) const
{
  const TetrahedralMesh moved{ nodes, this->Mesh.Tetrahedra };
  const double inside = 1e-9 * FindLongestEdge(this->Mesh);
  PointMatrix points = this->Points;
  ParallelFor(points.rows(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      const VolumePlace& place = this->Places[static_cast<std::size_t>(v)];
      if (place.Tetrahedron < 0)
      {
        continue;
      }
      points.row(v) = PositionOf(moved, place).transpose();
      if (this->Offsets.row(v).norm() > inside)
      {
        points.row(v) += this->Offsets.row(v) * RotationOf(this->Mesh, nodes, place.Tetrahedron).transpose();
      }
    }
  });
  return points;
}

TetrahedralMesh TetrahedraOf(const Surface& volume)
{
  RequireValidVolume(*volume.Volume, [&volume](std::int64_t t) { return volume.Cell(t); });
  return Compact(*volume.Volume);
}

ElasticDomain MakeElasticDomain(
  Surface& content, const TetrahedralMesh* tetrahedra, int surfacePoints, const Progress& progress)
{
  ElasticDomain domain;
  if (content.Volume && content.Volume->NumberOfTetrahedra() == 0)
  {
    throw InvalidInput("The vtkUnstructuredGrid has no tetrahedron; expected tetrahedra, or a vtkPolyData.");
  }
  if (content.Volume)
  {
    domain.Mesh = TetrahedraOf(content);
  }
  else
  {
    domain.Mesh = tetrahedra ? *tetrahedra : Filled(content, surfacePoints, SubProgress(progress, 0.0, 0.9));
  }
  domain.Points = content.Mesh.Points;
  domain.Weights = content.Volume ? LumpedMass(*content.Volume) : LumpedMass(content.Mesh);
  Bind(domain);
  Report(progress, 1.0);
  return domain;
}

} // namespace surfsynth
