// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Checks of surfaces for the tests of the meshing filters.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "SurfaceBridge.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/TriangleMesh.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <string>
#include <vector>

class vtkAlgorithm;

namespace surfsynthtest
{

/// The requirements of a closed manifold wound alike; without Closed, of any manifold wound alike.
surfsynth::MeshRequirements ValidSurface(bool closed);

/// Expects that @p surface is a manifold wound alike, and closed when asked.
void ExpectValid(vtkPolyData* surface, bool closed);

/// The triangles of a surface.
surfsynth::TriangleMesh MeshOf(vtkPolyData* surface);

/// V - E + F.
std::int64_t EulerCharacteristic(vtkPolyData* surface);

/// Volume enclosed by a closed surface, negative when it is wound inwards; of an open one, of the cone to the origin.
double VolumeOf(vtkPolyData* surface);
double AreaOf(vtkPolyData* surface);

/// Shortest, mean and longest edge, and the smallest angle in degrees.
struct Shapes
{
  double ShortestEdge = 0.0;
  double MeanEdge = 0.0;
  double LongestEdge = 0.0;
  double SmallestAngle = 180.0;
};
Shapes ShapesOf(vtkPolyData* surface);

/// Largest distance of a point of @p surface to @p reference.
double LargestDistance(vtkPolyData* surface, vtkPolyData* reference);

/// A cube of side 1 with @p n by @p n quads on each face.
Soup Cube(int n);

/// The points of @p surface for which @p predicate(x, y, z) holds.
std::vector<vtkIdType> PointsWhere(vtkPolyData* surface, const std::function<bool(const double*)>& predicate);

/// Adds a point array of one component with the value @p value(x, y, z).
vtkDataArray* AddPointArray(
  vtkPolyData* surface, const char* name, const std::function<double(const double*)>& value, int type = 11);

/// Runs the filter on @p input; the output, or null after an error.
vtkSmartPointer<vtkPolyData> OutputOf(vtkAlgorithm* filter, vtkDataObject* input);

/// Runs the filter on @p input, which it must refuse with one error that holds all of @p parts.
void ExpectRefusal(vtkAlgorithm* filter, vtkDataObject* input, const std::vector<std::string>& parts);

} // namespace surfsynthtest
