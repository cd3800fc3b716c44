// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of a surface with a geometric texture to a dataset.
#pragma once

#include "GeometricTextureResult.h"
#include "SurfaceBridge.h"

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// Names of the point arrays that are added to a textured surface.
struct GeometricTextureArrayNames
{
  std::string Displacement;
  std::string Level;
};

/// Fills @p output with the surface after step @p step of @p texture: geometry, the arrays of @p input, those of the
/// texture.
/// @param input the target of the texture; its precision of points is that of the output
/// @param surface @p input, converted
/// @param part fraction of the displacement of this step, in [0, 1]
void FillGeometricTextureSurface(vtkPolyData* input, const Surface& surface, const GeometricTextureResult& texture,
  int step, double part, const GeometricTextureArrayNames& names, vtkPolyData* output);

/// Fills @p output with a textured surface: geometry, the arrays of @p input, and the displacement.
/// @param input the target; its precision of points is that of the output
/// @param surface @p input, converted
/// @param base [V, 3], the points without texture
/// @param triangles as many times those of @p surface as subdivision makes: see SubdividedMesh
/// @param displacement [V, 3] @param name of the array of the displacement
void FillDisplacedSurface(vtkPolyData* input, const Surface& surface, const TriangleMesh& base,
  const PointMatrix& displacement, const std::string& name, vtkPolyData* output);

} // namespace surfsynth
