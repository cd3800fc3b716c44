// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces as VTK data, for the tests of the filters.
#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace surfsynthtest
{

/// Points and cells by hand.
struct Soup
{
  std::vector<double> Points; ///< x0 y0 z0 x1 ...
  std::vector<std::vector<vtkIdType>> Verts, Lines, Polys, Strips;

  vtkIdType AddPoint(double x, double y, double z);
  vtkIdType NumberOfPoints() const { return static_cast<vtkIdType>(this->Points.size() / 3); }
  /// @p pointType is VTK_DOUBLE, VTK_FLOAT, VTK_INT ...
  vtkSmartPointer<vtkPolyData> ToPolyData(int pointType = 11 /* VTK_DOUBLE */) const;
};

/// A closed sphere of radius 1: an icosahedron whose triangles are cut in four @p levels times (10 * 4^levels + 2
/// points).
Soup Icosphere(int levels);

/// A square of side 1 in the plane z = 0 with @p n cells of @p corners (3 or 4) corners along each side.
Soup Grid(int n, int corners = 3);

/// A sphere of latitude rings, quick to make at any size; about @p rings * @p sectors points, double precision.
vtkSmartPointer<vtkPolyData> RingSphere(int rings, int sectors);

} // namespace surfsynthtest
