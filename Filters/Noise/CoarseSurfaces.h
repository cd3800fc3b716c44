// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Refinement of surfaces that are too coarse to carry a random field. Private to the module.
#pragma once

#include <vtkSmartPointer.h>

#include <string>

class vtkDataObject;

namespace surfsynth
{

/// Divides the triangles of surfaces whose longest edge is longer than a third of the correlation range until no edge is
/// longer than a quarter of it, at midpoints of edges (vtkAdaptiveSubdivisionFilter), with at most 4 million triangles.
/// Arrays are interpolated linearly, but for two: the mask has 1 at a new point between two points with numbers other than
/// 0, else 0; and directions, whose signs do not matter, are averaged as axes (the main one of the mean of d d^T / |d|).
/// @param input a vtkPolyData or a composite dataset; not modified
/// @param range the correlation range, world units; 0 for 0.2 times the longest side of the box of each surface
/// @param mask name of the point array of the mask, empty for none
/// @param directions name of the point array of directions, empty for none
/// @return @p input itself when nothing is too coarse; else a copy in which those surfaces are refined
vtkSmartPointer<vtkDataObject> RefineCoarseSurfaces(
  vtkDataObject* input, double range, const std::string& mask = "", const std::string& directions = "");

} // namespace surfsynth
