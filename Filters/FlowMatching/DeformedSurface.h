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

/// Returns for each cell of @p surface the ratio of the area of its triangles with the points moved by @p displacement
/// to that without; 1 for cells that are neither polygons nor strips.
vtkSmartPointer<vtkDoubleArray> AreaRatios(vtkPolyData* surface, vtkDoubleArray* displacement, const std::string& name);

/// Moves the points of @p surface, in the same precision, and drops its normals, which are those of the old surface.
void MovePoints(vtkPolyData* surface, vtkDoubleArray* displacement);

} // namespace surfsynth
