// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Target with even triangles of a given size, remeshed once and kept.
#pragma once

#include "MeshProcessing/Remeshing/IsotropicRemeshing.h"
#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// Computes the ratio of the edges of about 7000 even triangles that cover @p target to its own mean edge length, within
/// [0.001, 1000]; 1 for a mesh without area.
double AutomaticTextureScale(const TriangleMesh& target);

/// A remeshed target, with the data that it depends on.
class RemeshedTarget
{
public:
  /// Remeshes @p input as vtkIsotropicRemeshFilter does by default, to a mean edge length of @p scale times its own.
  /// @param surface @p input, converted
  /// @param sizes of the used points of @p surface: factors of the edge length there, above 0; empty for 1
  /// @param levels number of levels of the synthesis: too many triangles for them are refused before any work
  /// @throws InvalidInput when the surface does not meet RemeshingRequirements(), there would be too many triangles, or
  /// the library was built without CGAL; Cancelled
  RemeshedTarget(vtkPolyData* input, const Surface& surface, double scale, const Eigen::VectorXf& sizes, int levels,
    const Progress& progress);

  /// Returns true when another remeshing of the same mesh would give this result: the seams of the arrays count too.
  bool Is(vtkPolyData* input, const Surface& surface, double scale, const Eigen::VectorXf& sizes) const;

  /// Fills @p output with the target and the current arrays of @p input.
  void Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const;

private:
  double Scale;
  Eigen::VectorXf Sizes;
  std::vector<Index> Seams; ///< classes of the points
  RemeshedSurface Remeshed;
};

} // namespace surfsynth
