// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field latents as point arrays.
#pragma once

#include "SurfaceBridge.h"
#include "WeldedSurface.h"

#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// True when AddLatentArrays() with the name @p latentName may make an array @p name.
bool IsLatentName(const std::string& name, const std::string& latentName);

/// Adds the point arrays <name>_0, ..., <name>Deviation and <name>Radius of the header of vtkFieldLatentEncoder to @p
/// output, a copy of the surface.
/// @param codes of all points; those that are no vertices are not read
void AddLatentArrays(
  const WeldedSurface& welded, const FieldLatentCodes& codes, const std::string& name, vtkPolyData* output);

/// Codes of a surface that were read from its arrays.
struct LatentField
{
  FieldLatentMatrix Latents; ///< [V, 2 d], for FieldLatentDecoder::Decode(); 0 for points that are no vertices
  std::vector<double> Radii; ///< [V], r_p, world units; 0 for points that are no vertices
  std::string Warning;       ///< text about a surface that was scaled or turned after encoding; empty without one
};

/// Reads the arrays <name>_0 to <name>_<d - 1> and <name>Radius of @p polydata, from which @p surface was converted, and
/// projects the vectors to the tangent planes. On the triangulation that was encoded all radii are those of the rings, and
/// vectors lie in the tangent planes: where the ratio of the radii is the same everywhere but not 1, or where it is 1 and
/// vectors have normal components, there is a warning.
/// @throws InvalidInput when arrays are missing, there are more than @p dimension, one is of another shape or not
/// finite, or a radius is not larger than 0.
LatentField ReadLatentArrays(vtkPolyData* polydata, const Surface& surface, const WeldedSurface& welded,
  const std::string& name, std::int64_t dimension);

} // namespace surfsynth
