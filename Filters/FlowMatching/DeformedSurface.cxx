// SPDX-License-Identifier: BSD-3-Clause
#include "DeformedSurface.h"

#include "NewArray.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include "Core/Operators/SurfaceOperators.h"

#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

namespace surfsynth
{

namespace
{
/// Computes the area of the triangles of each cell.
Eigen::VectorXd CellAreas(const Surface& surface, const TriangleMesh& mesh, Eigen::Index cells)
{
  const Eigen::VectorXd areas = FaceAreas(mesh);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(cells);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    sums[surface.Cell(f)] += areas[f];
  }
  return sums;
}

template <typename Array>
vtkSmartPointer<Array> MovedCoordinates(vtkPolyData* surface, vtkDoubleArray* displacement)
{
  auto moved = NewArray<Array>("Points", surface->GetNumberOfPoints(), 3);
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    double point[3];
    surface->GetPoint(p, point);
    for (int c = 0; c < 3; ++c)
    {
      moved->SetTypedComponent(
        p, c, static_cast<typename Array::ValueType>(point[c] + displacement->GetTypedComponent(p, c)));
    }
  }
  return moved;
}
} // namespace

vtkSmartPointer<vtkDoubleArray> AreaRatios(vtkPolyData* surface, vtkDoubleArray* displacement, const std::string& name)
{
  auto ratios = NewArray<vtkDoubleArray>(name, surface->GetNumberOfCells(), 1);
  ratios->FillValue(1.0);
  if (surface->GetNumberOfPolys() + surface->GetNumberOfStrips() == 0)
  {
    return ratios; // a piece of a surface may have points only
  }
  const Surface source = ConvertSurface(surface);
  TriangleMesh deformed = source.Mesh;
  deformed.Points += Eigen::Map<const PointMatrix>(displacement->GetPointer(0), deformed.Points.rows(), 3);
  const Eigen::VectorXd before = CellAreas(source, source.Mesh, surface->GetNumberOfCells());
  const Eigen::VectorXd after = CellAreas(source, deformed, surface->GetNumberOfCells());
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell)
  {
    if (before[cell] > 0.0)
    {
      ratios->SetValue(cell, after[cell] / before[cell]);
    }
  }
  return ratios;
}

void MovePoints(vtkPolyData* surface, vtkDoubleArray* displacement)
{
  vtkNew<vtkPoints> moved;
  if (HasDoublePoints(surface))
  {
    moved->SetData(MovedCoordinates<vtkDoubleArray>(surface, displacement));
  }
  else
  {
    moved->SetData(MovedCoordinates<vtkFloatArray>(surface, displacement));
  }
  surface->SetPoints(moved);
  DropNormals(surface);
}

} // namespace surfsynth
