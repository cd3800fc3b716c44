// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Fills a sphere with tetrahedra, which works only where the program that runs TetGen is found, and checks their
/// volume against the topology report of the sphere.
#include <vtkCell.h>
#include <vtkNew.h>
#include <vtkPlatonicSolidSource.h>
#include <vtkPoints.h>
#include <vtkTetra.h>
#include <vtkTetrahedralizeFilter.h>
#include <vtkTopologyReport.h>
#include <vtkUnstructuredGrid.h>

#include <cmath>
#include <iostream>

int main()
{
  vtkNew<vtkPlatonicSolidSource> solid;
  solid->SetSolidTypeToIcosahedron();
  vtkNew<vtkTetrahedralizeFilter> fill;
  fill->SetInputConnection(solid->GetOutputPort());
  fill->SetTargetEdgeLength(0.3);
  fill->Update();
  auto* grid = vtkUnstructuredGrid::SafeDownCast(fill->GetOutputDataObject(0));
  double volume = 0.0;
  for (vtkIdType cell = 0; grid && cell < grid->GetNumberOfCells(); ++cell)
  {
    double corners[4][3];
    for (int k = 0; k < 4; ++k)
    {
      grid->GetCell(cell)->GetPoints()->GetPoint(k, corners[k]);
    }
    volume += vtkTetra::ComputeVolume(corners[0], corners[1], corners[2], corners[3]);
  }
  vtkNew<vtkTopologyReport> report;
  report->SetInputConnection(solid->GetOutputPort());
  report->Update();
  const double expected = std::abs(report->GetValue("Volume"));
  if (!(expected > 2.0 && std::abs(volume - expected) < 1e-5 * expected))
  {
    std::cerr << "the tetrahedra have the volume " << volume << ", the sphere " << expected << "\n";
    return 1;
  }
  std::cout << grid->GetNumberOfCells() << " tetrahedra of volume " << volume << "\n";
  return 0;
}
