// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces, and checks of tetrahedra, for the tests of vtkTetrahedralizeFilter.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkTetrahedralizeFilter.h"

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <functional>
#include <map>
#include <vector>

namespace surfsynthtest
{

/// The closed surface of a box: 8 points, two triangles or one quad on each side.
Soup Box(const std::array<double, 3>& lower, const std::array<double, 3>& upper, int corners = 3);

/// Icosphere(levels) of this radius around (x, 0, 0).
Soup Shell(int levels, double radius, double x = 0.0);

/// All of them as one surface, without shared points.
Soup Joined(const std::vector<Soup>& parts);

/// The output of a filter with some parameters; an error is a failure of the test.
vtkSmartPointer<vtkUnstructuredGrid> TetrahedraOf(
  vtkDataObject* surface, const std::function<void(vtkTetrahedralizeFilter*)>& change = {});

double VolumeOf(vtkUnstructuredGrid* grid);

/// Volume by the array Region.
std::map<int, double> RegionVolumes(vtkUnstructuredGrid* grid);

struct TetrahedronShapes
{
  double SmallestVolume;
  double LargestVolume;
  double LargestRadiusEdgeRatio; ///< circumradius over shortest edge
};
/// @param inner only of tetrahedra without a point on the surface
TetrahedronShapes ShapesOf(vtkUnstructuredGrid* grid, bool inner = false);

/// Every tetrahedron has a volume above zero.
void ExpectPositiveTetrahedra(vtkUnstructuredGrid* grid);

/// The first points of the grid are those of the surface, bit for bit.
void ExpectFirstPoints(vtkUnstructuredGrid* grid, vtkPolyData* surface);

/// Same points, cells and arrays, bit for bit.
void ExpectSameGrid(vtkUnstructuredGrid* a, vtkUnstructuredGrid* b);

} // namespace surfsynthtest
