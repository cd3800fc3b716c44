// SPDX-License-Identifier: BSD-3-Clause
#include "PlanarMeshes.h"

#include "Core/Common/Parallel.h"
#include "Core/Random/CounterUniforms.h"

#include <vtkCellArray.h>
#include <vtkDelaunay2D.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace surfsynth
{

namespace
{
/// Candidates of the farthest-point sampling for each point.
constexpr std::int64_t CandidatesOfPoint = 8;
/// The least height of a triangle over its longest side.
constexpr double FlattestTriangle = 1e-3;
/// Stream of random numbers; the training has others.
constexpr std::uint32_t CandidateStream = 20;

/// Uniform points of the unit square.
PlanarPoints Candidates(std::int64_t count, std::int64_t mesh, std::uint64_t seed)
{
  NormalKey key;
  key.Seed = seed;
  key.Sample = static_cast<std::uint32_t>(mesh);
  key.Stream = CandidateStream;
  PlanarPoints points(count, 2);
  for (std::int64_t k = 0; k < points.size(); ++k)
  {
    points.data()[k] = Uniform(key, k);
  }
  return points;
}

/// Chooses @p count of the candidates, from the first on each the farthest from those before it.
PlanarPoints FarthestPoints(const PlanarPoints& candidates, std::int64_t count)
{
  const Eigen::ArrayXd x = candidates.col(0);
  const Eigen::ArrayXd y = candidates.col(1);
  Eigen::ArrayXd squares = Eigen::ArrayXd::Constant(x.size(), std::numeric_limits<double>::infinity());
  PlanarPoints chosen(count, 2);
  Eigen::Index last = 0;
  for (std::int64_t k = 0; k < count; ++k)
  {
    chosen.row(k) = candidates.row(last);
    squares = squares.min((x - x[last]).square() + (y - y[last]).square());
    squares.maxCoeff(&last);
  }
  return chosen;
}

/// Triangles of the Delaunay triangulation, counterclockwise, without flat ones at the border.
PlanarMesh Triangulate(PlanarPoints points)
{
  vtkNew<vtkPoints> given;
  given->SetDataTypeToDouble();
  given->SetNumberOfPoints(points.rows());
  for (Eigen::Index p = 0; p < points.rows(); ++p)
  {
    given->SetPoint(p, points(p, 0), points(p, 1), 0.0);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(given);
  vtkNew<vtkDelaunay2D> delaunay;
  delaunay->SetInputData(data);
  delaunay->SetTolerance(0.0);
  delaunay->Update();
  vtkCellArray* polygons = delaunay->GetOutput()->GetPolys();
  vtkNew<vtkIdList> ids;
  std::vector<Index> kept;
  for (vtkIdType cell = 0; cell < polygons->GetNumberOfCells(); ++cell)
  {
    polygons->GetCellAtId(cell, ids);
    std::array<Index, 3> corners{};
    std::transform(
      ids->begin(), ids->begin() + 3, corners.begin(), [](vtkIdType id) { return static_cast<Index>(id); });
    const auto side = [&](std::size_t k) {
      return Eigen::RowVector2d(points.row(corners[(k + 1) % 3]) - points.row(corners[k]));
    };
    const double doubled = side(0).x() * side(1).y() - side(0).y() * side(1).x();
    const double longest = std::max({ side(0).squaredNorm(), side(1).squaredNorm(), side(2).squaredNorm() });
    if (doubled < 0.0)
    {
      std::swap(corners[1], corners[2]);
    }
    if (std::abs(doubled) > FlattestTriangle * longest)
    {
      kept.insert(kept.end(), corners.begin(), corners.end());
    }
  }
  PlanarMesh mesh;
  mesh.Triangles = Eigen::Map<const TriangleMatrix>(kept.data(), static_cast<Eigen::Index>(kept.size() / 3), 3);
  mesh.Points = std::move(points);
  return mesh;
}
} // namespace

std::vector<PlanarMesh> MakePlanarMeshes(
  std::int64_t count, std::int64_t points, std::uint64_t seed, const Progress& progress)
{
  std::vector<PlanarMesh> meshes(static_cast<std::size_t>(count));
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    count,
    [&](std::int64_t mesh) {
      meshes[static_cast<std::size_t>(mesh)].Points = FarthestPoints(
        Candidates(CandidatesOfPoint * points, mesh, seed), points);
      ++done;
    },
    [&] { Report(progress, 0.5 * static_cast<double>(done) / static_cast<double>(count)); });
  for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) // VTK's filters run on the calling thread
  {
    Report(progress, 0.5 + 0.5 * static_cast<double>(mesh) / static_cast<double>(count));
    meshes[mesh] = Triangulate(std::move(meshes[mesh].Points));
  }
  return meshes;
}

} // namespace surfsynth
