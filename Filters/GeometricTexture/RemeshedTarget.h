// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A target with even triangles of a wanted size, made once and kept.
#pragma once

#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"
#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"

#include <memory>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

class RemeshedTarget
{
public:
  /// Remeshes @p input as vtkIsotropicRemeshFilter does by default, to a mean edge length of @p scale times its own.
  /// @param surface @p input, converted
  /// @param levels how many will grow on it: before any work, more triangles than they can have are refused
  /// @throws InvalidInput when the surface does not meet RemeshingRequirements(), there would be too many triangles, or
  /// the library was built without CGAL; Cancelled
  RemeshedTarget(vtkPolyData* input, const Surface& surface, double scale, int levels, const Progress& progress);

  /// Whether this is what another remeshing of the same mesh would give: the seams of the arrays count too.
  bool Is(vtkPolyData* input, const Surface& surface, double scale) const;

  /// The target, with the arrays that @p input has now.
  void Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const;

private:
  double Scale;
  std::vector<Index> Seams; ///< classes of the points
  RemeshedSurface Remeshed;
};

} // namespace surfsynth
