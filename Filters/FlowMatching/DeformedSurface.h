// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A surface whose points have been moved.
#pragma once

#include <vtkDoubleArray.h>
#include <vtkSmartPointer.h>

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// For each cell of @p surface, the area of its triangles with the points moved by @p displacement over that without; 1
/// for cells that are neither polygons nor strips.
vtkSmartPointer<vtkDoubleArray> AreaRatios(vtkPolyData* surface, vtkDoubleArray* displacement, const std::string& name);

/// Moves the points of @p surface, which get new coordinates of the same precision, and drops the normals, which are
/// those of the old surface.
void MovePoints(vtkPolyData* surface, vtkDoubleArray* displacement);

} // namespace surfsynth
