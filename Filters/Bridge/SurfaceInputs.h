// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces that lie in unstructured grids, as clipping and thresholding make them.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>

class vtkDataObject;
class vtkInformation;
class vtkInformationVector;

namespace surfsynth
{

/// Returns @p data with a vtkPolyData in place of each vtkUnstructuredGrid of linear cells of at most two dimensions
/// (vertices, lines, triangles, strips, polygons, pixels, quadrilaterals): of @p data itself, or of the leaves of a
/// tree. Points, point arrays and field data are shared with the grid; cells are in the order of vtkPolyData (vertices,
/// lines, polygons, strips), and cell arrays with them. Everything else, grids with other cells included, is returned
/// as it is; null for null. Where there is no such grid, the result is @p data.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkDataObject> AsSurfaces(vtkDataObject* data);

/// Returns the first dataset of a port as AsSurfaces() does; null when it is no surface, or there is none.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkPolyData> SurfaceOn(vtkInformationVector* port);

/// Class of @p data with an article, for messages; of an unstructured grid the first cell that is no surface, too:
/// "a vtkUnstructuredGrid with cells that are no polygons (first cell 0: Tetra)". "missing" for null.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string DescribeInput(vtkDataObject* data);

/// Accepts one vtkPolyData or vtkUnstructuredGrid on the port; for FillInputPortInformation.
VTKSURFACESYNTHESISBRIDGE_EXPORT int AcceptSurface(vtkInformation* info);

/// RequestDataObject of a filter that adds arrays to surfaces: the output is a tree of the input's class, or a
/// vtkPolyData.
VTKSURFACESYNTHESISBRIDGE_EXPORT int RequestSurfaces(vtkDataObject* input, vtkInformationVector* outputVector);

} // namespace surfsynth
