// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Volumes of tetrahedra as VTK data, for the tests of the filters.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"

#include <vtkCellType.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

namespace surfsynthtest
{

/// The tetrahedra as a grid; @p type of the points is VTK_DOUBLE or VTK_FLOAT.
inline vtkSmartPointer<vtkUnstructuredGrid> GridOf(const surfsynth::TetrahedralMesh& mesh, int type = VTK_DOUBLE)
{
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataType(type);
  for (surfsynth::Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    points->InsertNextPoint(mesh.Points.row(v).data());
  }
  grid->SetPoints(points);
  for (surfsynth::Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    const vtkIdType ids[4] = { mesh.Tetrahedra(t, 0), mesh.Tetrahedra(t, 1), mesh.Tetrahedra(t, 2),
      mesh.Tetrahedra(t, 3) };
    grid->InsertNextCell(VTK_TETRA, 4, ids);
  }
  return grid;
}

} // namespace surfsynthtest
