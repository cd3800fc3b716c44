// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of tetrahedra to an unstructured grid. Private to the module.
#pragma once

#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"

#include "SurfaceBridge.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkPolyData;
class vtkUnstructuredGrid;

namespace surfsynth
{

/// A surface without the points that no triangle uses.
struct UsedSurface
{
  /// Copies the used points of @p surface and renumbers its triangles.
  explicit UsedSurface(const TriangleMesh& surface);

  TriangleMesh Mesh;
  std::vector<std::int64_t> Points; ///< [V], their ids in the whole surface, ascending
};

/// Names of the arrays that are added.
struct GridNames
{
  std::string Region;
  std::string OnSurface;
};

/// Fills @p output with the mesh, which was made of @p used, with the arrays of @p input and, with @p surfaceTriangles,
/// the triangles of the surface as cells.
void FillGrid(vtkUnstructuredGrid* output, const GridNames& names, vtkPolyData* input, const Surface& surface,
  const UsedSurface& used, const FilledSurface& mesh, bool surfaceTriangles);

} // namespace surfsynth
