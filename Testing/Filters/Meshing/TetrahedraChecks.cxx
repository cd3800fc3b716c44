// SPDX-License-Identifier: BSD-3-Clause
#include "TetrahedraChecks.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace surfsynthtest
{

namespace
{
/// Calls visit(cell, corners) for each tetrahedron, with its corners in the columns.
void EachTetrahedron(
  vtkUnstructuredGrid* grid, const std::function<void(vtkIdType, const Eigen::Matrix<double, 3, 4>&)>& visit)
{
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
  {
    if (grid->GetCellType(c) != VTK_TETRA)
    {
      continue;
    }
    grid->GetCellPoints(c, ids);
    Eigen::Matrix<double, 3, 4> corners;
    for (int k = 0; k < 4; ++k)
    {
      grid->GetPoint(ids->GetId(k), corners.col(k).data());
    }
    visit(c, corners);
  }
}

Eigen::Matrix3d EdgesOf(const Eigen::Matrix<double, 3, 4>& corners)
{
  return corners.rightCols<3>().colwise() - corners.col(0);
}

double Volume(const Eigen::Matrix<double, 3, 4>& corners) { return EdgesOf(corners).determinant() / 6.0; }

double RadiusEdgeRatio(const Eigen::Matrix<double, 3, 4>& corners)
{
  // The centre is as far from the first corner as from the others: 2 e_k . x = e_k . e_k.
  const Eigen::Matrix3d edges = EdgesOf(corners);
  const Eigen::Vector3d center =
    (2.0 * edges.transpose()).fullPivLu().solve(Eigen::Vector3d(edges.colwise().squaredNorm().transpose()));
  double shortest = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 4; ++a)
  {
    for (int b = 0; b < a; ++b)
    {
      shortest = std::min(shortest, (corners.col(a) - corners.col(b)).norm());
    }
  }
  return center.norm() / shortest;
}
} // namespace

Soup Box(const std::array<double, 3>& lower, const std::array<double, 3>& upper, int corners)
{
  Soup box;
  for (int k = 0; k < 8; ++k)
  {
    box.AddPoint(k & 1 ? upper[0] : lower[0], k & 2 ? upper[1] : lower[1], k & 4 ? upper[2] : lower[2]);
  }
  const std::vector<std::vector<vtkIdType>> sides = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 },
    { 0, 4, 6, 2 }, { 1, 3, 7, 5 } };
  for (const auto& side : sides)
  {
    if (corners == 4)
    {
      box.Polys.push_back(side);
    }
    else
    {
      box.Polys.push_back({ side[0], side[1], side[2] });
      box.Polys.push_back({ side[0], side[2], side[3] });
    }
  }
  return box;
}

Soup Shell(int levels, double radius, double x)
{
  Soup shell = Icosphere(levels);
  for (std::size_t k = 0; k < shell.Points.size(); ++k)
  {
    shell.Points[k] = radius * shell.Points[k] + (k % 3 == 0 ? x : 0.0);
  }
  return shell;
}

Soup Joined(const std::vector<Soup>& parts)
{
  Soup all;
  for (const Soup& part : parts)
  {
    const vtkIdType first = all.NumberOfPoints();
    all.Points.insert(all.Points.end(), part.Points.begin(), part.Points.end());
    for (auto cell : part.Polys)
    {
      std::for_each(cell.begin(), cell.end(), [first](vtkIdType& id) { id += first; });
      all.Polys.push_back(cell);
    }
  }
  return all;
}

vtkSmartPointer<vtkUnstructuredGrid> TetrahedraOf(
  vtkDataObject* surface, const std::function<void(vtkTetrahedralizeFilter*)>& change)
{
  vtkNew<vtkTetrahedralizeFilter> filter;
  filter->SetInputDataObject(surface);
  if (change)
  {
    change(filter);
  }
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  vtkSmartPointer<vtkUnstructuredGrid> grid = vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_TRUE(grid && grid->GetNumberOfCells() > 0);
  return grid;
}

double VolumeOf(vtkUnstructuredGrid* grid)
{
  double volume = 0.0;
  EachTetrahedron(grid, [&](vtkIdType, const auto& corners) { volume += Volume(corners); });
  return volume;
}

std::map<int, double> RegionVolumes(vtkUnstructuredGrid* grid)
{
  std::map<int, double> volumes;
  vtkDataArray* regions = grid->GetCellData()->GetArray("Region");
  EachTetrahedron(grid, [&](vtkIdType c, const auto& corners) {
    volumes[static_cast<int>(regions->GetComponent(c, 0))] += Volume(corners);
  });
  return volumes;
}

TetrahedronShapes ShapesOf(vtkUnstructuredGrid* grid, bool inner)
{
  TetrahedronShapes shapes{ std::numeric_limits<double>::infinity(), 0.0, 0.0 };
  vtkDataArray* onSurface = grid->GetPointData()->GetArray("OnSurface");
  EachTetrahedron(grid, [&](vtkIdType c, const auto& corners) {
    vtkNew<vtkIdList> ids;
    grid->GetCellPoints(c, ids);
    if (inner && std::any_of(ids->begin(), ids->end(), [&](vtkIdType p) { return onSurface->GetComponent(p, 0) > 0; }))
    {
      return;
    }
    shapes.SmallestVolume = std::min(shapes.SmallestVolume, Volume(corners));
    shapes.LargestVolume = std::max(shapes.LargestVolume, Volume(corners));
    shapes.LargestRadiusEdgeRatio = std::max(shapes.LargestRadiusEdgeRatio, RadiusEdgeRatio(corners));
  });
  return shapes;
}

void ExpectPositiveTetrahedra(vtkUnstructuredGrid* grid) { EXPECT_GT(ShapesOf(grid).SmallestVolume, 0.0); }

void ExpectFirstPoints(vtkUnstructuredGrid* grid, vtkPolyData* surface)
{
  ASSERT_GE(grid->GetNumberOfPoints(), surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    double a[3], b[3];
    grid->GetPoint(p, a);
    surface->GetPoint(p, b);
    EXPECT_TRUE(std::equal(a, a + 3, b)) << "point " << p;
  }
}

void ExpectSameGrid(vtkUnstructuredGrid* a, vtkUnstructuredGrid* b)
{
  EXPECT_TRUE(SameBits(a->GetPoints()->GetData(), b->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(a->GetCells()->GetConnectivityArray(), b->GetCells()->GetConnectivityArray()));
  ASSERT_EQ(a->GetPointData()->GetNumberOfArrays(), b->GetPointData()->GetNumberOfArrays());
  for (int k = 0; k < a->GetPointData()->GetNumberOfArrays(); ++k)
  {
    EXPECT_TRUE(SameBits(a->GetPointData()->GetArray(k), b->GetPointData()->GetArray(k)));
  }
  EXPECT_TRUE(SameBits(a->GetCellData()->GetArray("Region"), b->GetCellData()->GetArray("Region")));
}

} // namespace surfsynthtest
