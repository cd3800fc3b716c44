// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces of displacement maps, and the maps as VTK's images. Private to the module.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Atlas/DisplacementMap.h"

class vtkImageData;
class vtkPolyData;

namespace surfsynth
{

/// Converts and checks the surface with the atlas. @throws InvalidInput
Surface ToPlainSurface(vtkPolyData* polydata);

/// Converts the detailed surface, whose used points must be finite; there may be other defects. Points that no triangle uses
/// are left out. @throws InvalidInput
TriangleMesh ToDetailedMesh(vtkPolyData* polydata);

/// Value of height 0 and difference of the values 1 and 0 in images of integers.
struct HeightEncoding
{
  double Midlevel = 0.0; ///< in [0, 1]
  double Scale = 1.0;    ///< world units
};
HeightEncoding EncodingOf(const DisplacementMap& map);

/// Fills @p image with the arrays of vtkDisplacementMapFilter.
void FillDisplacementImage(const DisplacementMap& map, const AtlasRasterOptions& size, vtkImageData* image);

} // namespace surfsynth
