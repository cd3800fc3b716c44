// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A surface with a geometric texture as a dataset.
#pragma once

#include "GeometricTextureResult.h"
#include "SurfaceBridge.h"

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// Names of the point arrays that a textured surface gets.
struct GeometricTextureArrayNames
{
  std::string Displacement;
  std::string Level;
};

/// Fills @p output with the surface after step @p step of @p texture: geometry, the arrays of @p input, those of the
/// texture.
/// @param input what the texture was grown on; its points are stored as those of the output are.
/// @param surface @p input, converted
/// @param part of the displacement of this step that has taken place, in [0, 1]
void FillGeometricTextureSurface(vtkPolyData* input, const Surface& surface, const GeometricTextureResult& texture,
  int step, double part, const GeometricTextureArrayNames& names, vtkPolyData* output);

} // namespace surfsynth
