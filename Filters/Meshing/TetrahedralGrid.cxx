// SPDX-License-Identifier: BSD-3-Clause
#include "TetrahedralGrid.h"

#include "SurfaceArrays.h"

#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>

namespace surfsynth
{

namespace
{
void SetPoints(vtkUnstructuredGrid* output, const PointMatrix& matrix)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(matrix.rows());
  std::copy_n(matrix.data(), matrix.size(), vtkDoubleArray::SafeDownCast(points->GetData())->GetPointer(0));
  output->SetPoints(points);
}

void SetCells(vtkUnstructuredGrid* output, const TetrahedronMatrix& tetrahedra, const TriangleMatrix& triangles)
{
  const vtkIdType count = tetrahedra.rows() + triangles.rows();
  vtkNew<vtkIdTypeArray> offsets;
  offsets->SetNumberOfValues(count + 1);
  vtkNew<vtkUnsignedCharArray> types;
  types->SetNumberOfValues(count);
  vtkIdType offset = 0;
  for (vtkIdType cell = 0; cell < count; ++cell)
  {
    const bool isTetrahedron = cell < tetrahedra.rows();
    offsets->SetValue(cell, offset);
    types->SetValue(cell, isTetrahedron ? VTK_TETRA : VTK_TRIANGLE);
    offset += isTetrahedron ? 4 : 3;
  }
  offsets->SetValue(count, offset);
  vtkNew<vtkIdTypeArray> ids;
  ids->SetNumberOfValues(offset);
  std::copy_n(tetrahedra.data(), tetrahedra.size(), ids->GetPointer(0));
  std::copy_n(triangles.data(), triangles.size(), ids->GetPointer(0) + tetrahedra.size());
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  output->SetCells(types, cells);
}

/// Returns for each new point the triangle of the surface on which it lies, -1 inside.
std::vector<Index> TrianglesOfNewPoints(const FilledSurface& mesh, Index given)
{
  std::vector<Index> triangles(static_cast<std::size_t>(mesh.Points.rows() - given), -1);
  for (std::size_t k = 0; k < mesh.Triangles.size(); ++k)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      const Index p = mesh.Faces(static_cast<Eigen::Index>(k), corner);
      if (p >= given)
      {
        triangles[p - given] = mesh.Triangles[k];
      }
    }
  }
  return triangles;
}

/// Returns the place on the surface from which each point takes its arrays.
std::vector<SurfacePlace> PlacesOf(
  const FilledSurface& mesh, const TriangleMesh& surface, const std::vector<Index>& triangleOfNew)
{
  const Index given = surface.NumberOfPoints();
  std::vector<SurfacePlace> places(static_cast<std::size_t>(mesh.Points.rows()));
  for (Index f = 0; f < surface.NumberOfTriangles(); ++f)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      SurfacePlace& place = places[surface.Triangles(f, corner)];
      place.Triangle = f;
      place.Weights = Eigen::Vector3d::Unit(corner);
    }
  }
  std::vector<Index> inside;
  for (Index p = given; p < static_cast<Index>(mesh.Points.rows()); ++p)
  {
    const Index f = triangleOfNew[p - given];
    if (f < 0)
    {
      inside.push_back(p);
    }
    else
    {
      places[p] = NearestOnTriangle(surface, f, mesh.Points.row(p).transpose());
    }
  }
  PointMatrix points(static_cast<Eigen::Index>(inside.size()), 3);
  for (std::size_t k = 0; k < inside.size(); ++k)
  {
    points.row(static_cast<Eigen::Index>(k)) = mesh.Points.row(inside[k]);
  }
  const std::vector<SurfacePlace> nearest = NearestPlaces(surface).Find(points);
  for (std::size_t k = 0; k < inside.size(); ++k)
  {
    places[inside[k]] = nearest[k];
  }
  return places;
}

/// Adds the point arrays of the surface: interpolated, and exact on its own points.
void AddPointArrays(vtkUnstructuredGrid* output, vtkPolyData* input, const Surface& surface, const UsedSurface& used,
  std::vector<SurfacePlace> places)
{
  TriangleMesh original; // the triangles by the ids that the arrays have
  original.Triangles = surface.Mesh.Triangles;
  vtkPointData* target = output->GetPointData();
  InterpolateArrays(input->GetPointData(), original, places, target);
  vtkNew<vtkPointData> exact;
  PickArrays(input->GetPointData(), used.Points, exact);
  for (int k = 0; k < target->GetNumberOfArrays() && k < exact->GetNumberOfArrays(); ++k)
  {
    target->GetAbstractArray(k)->InsertTuples(
      0, exact->GetAbstractArray(k)->GetNumberOfTuples(), 0, exact->GetAbstractArray(k));
  }
}

/// Adds the cell arrays of the surface on its triangles, after zeros for the tetrahedra.
void AddCellArrays(vtkUnstructuredGrid* output, vtkPolyData* input, const Surface& surface, const FilledSurface& mesh)
{
  std::vector<std::int64_t> cells;
  for (const Index f : mesh.Triangles)
  {
    cells.push_back(surface.Cell(f));
  }
  vtkNew<vtkCellData> picked;
  PickArrays(input->GetCellData(), cells, picked);
  const vtkIdType tetrahedra = mesh.Tetrahedra.rows();
  for (int k = 0; k < picked->GetNumberOfArrays(); ++k)
  {
    vtkAbstractArray* old = picked->GetAbstractArray(k);
    const auto made = vtkSmartPointer<vtkAbstractArray>::Take(old->NewInstance());
    made->SetName(old->GetName());
    made->SetNumberOfComponents(old->GetNumberOfComponents());
    made->CopyComponentNames(old);
    made->SetNumberOfTuples(tetrahedra + old->GetNumberOfTuples());
    if (auto* numbers = vtkDataArray::SafeDownCast(made))
    {
      numbers->Fill(0.0);
    }
    made->InsertTuples(tetrahedra, old->GetNumberOfTuples(), 0, old);
    output->GetCellData()->AddArray(made);
  }
}

void AddRegions(vtkUnstructuredGrid* output, const std::string& name, const FilledSurface& mesh,
  const std::vector<Index>& patchOfTriangle)
{
  vtkNew<vtkIntArray> regions;
  regions->SetName(name.c_str());
  regions->SetNumberOfValues(output->GetNumberOfCells());
  std::copy(mesh.Regions.begin(), mesh.Regions.end(), regions->GetPointer(0));
  for (vtkIdType cell = mesh.Tetrahedra.rows(); cell < output->GetNumberOfCells(); ++cell)
  {
    regions->SetValue(cell, patchOfTriangle[mesh.Triangles[cell - mesh.Tetrahedra.rows()]]);
  }
  output->GetCellData()->AddArray(regions);
}

void AddOnSurface(
  vtkUnstructuredGrid* output, const std::string& name, Index given, const std::vector<Index>& triangleOfNew)
{
  vtkNew<vtkUnsignedCharArray> onSurface;
  onSurface->SetName(name.c_str());
  onSurface->SetNumberOfValues(output->GetNumberOfPoints());
  std::fill_n(onSurface->GetPointer(0), given, static_cast<unsigned char>(1));
  std::transform(triangleOfNew.begin(), triangleOfNew.end(), onSurface->GetPointer(0) + given,
    [](Index f) { return static_cast<unsigned char>(f >= 0 ? 1 : 0); });
  output->GetPointData()->AddArray(onSurface);
}
} // namespace

UsedSurface::UsedSurface(const TriangleMesh& surface)
{
  std::vector<Index> newId(static_cast<std::size_t>(surface.NumberOfPoints()), -1);
  std::for_each(
    surface.Triangles.data(), surface.Triangles.data() + surface.Triangles.size(), [&](Index p) { newId[p] = 0; });
  for (Index p = 0; p < surface.NumberOfPoints(); ++p)
  {
    if (newId[p] == 0)
    {
      newId[p] = static_cast<Index>(this->Points.size());
      this->Points.push_back(p);
    }
  }
  this->Mesh.Points.resize(static_cast<Eigen::Index>(this->Points.size()), 3);
  for (std::size_t k = 0; k < this->Points.size(); ++k)
  {
    this->Mesh.Points.row(static_cast<Eigen::Index>(k)) = surface.Points.row(this->Points[k]);
  }
  this->Mesh.Triangles = surface.Triangles.unaryExpr([&](Index p) { return newId[p]; });
}

void FillGrid(vtkUnstructuredGrid* output, const GridNames& names, vtkPolyData* input, const Surface& surface,
  const UsedSurface& used, const FilledSurface& mesh, bool surfaceTriangles)
{
  const Index given = used.Mesh.NumberOfPoints();
  const std::vector<Index> triangleOfNew = TrianglesOfNewPoints(mesh, given);
  SetPoints(output, mesh.Points);
  SetCells(output, mesh.Tetrahedra, surfaceTriangles ? mesh.Faces : TriangleMatrix(0, 3));
  AddPointArrays(output, input, surface, used, PlacesOf(mesh, used.Mesh, triangleOfNew));
  if (surfaceTriangles)
  {
    AddCellArrays(output, input, surface, mesh);
  }
  AddRegions(output, names.Region, mesh, mesh.Patches);
  AddOnSurface(output, names.OnSurface, given, triangleOfNew);
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
}

} // namespace surfsynth
