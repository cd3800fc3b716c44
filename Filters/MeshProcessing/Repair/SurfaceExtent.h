// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Area, volume and components of a surface before and after a repair. Private to the mesh processing.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>

namespace surfsynth
{

/// Size of a surface.
struct SurfaceExtent
{
  double Area = 0.0;           ///< square world units
  double Volume = 0.0;         ///< cubic world units, sum of the absolute volumes of the components; 0 when open
  std::int64_t Components = 0; ///< number of components: triangles that are joined by points
  bool IsClosed = false;       ///< no boundary; only then Volume is defined
};

/// Measures a consistently wound mesh. O(V + F).
/// @param isClosed the mesh has no boundary
SurfaceExtent MeasureExtent(const TriangleMesh& mesh, bool isClosed);

/// Largest of three fractions, at least 0: the area lost, the volume lost (when both surfaces are closed) and the
/// components lost or gained.
double LargestLoss(const SurfaceExtent& before, const SurfaceExtent& after);

/// Fraction (before - after) / before, at least 0; 0 when @p before is 0.
double LostFraction(double before, double after);

} // namespace surfsynth
