// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Centers of patches, evenly distributed over a surface. Private to the inference.
#pragma once

#include "Core/Random/CounterNormals.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Distribution of the centers of patches.
struct PatchDistribution
{
  double Spacing = 1.0;                    ///< of the grids, world units
  Eigen::VectorXf Sizes;                   ///< [V], factors of the spacing; empty for 1
  const PointMatrix* Directions = nullptr; ///< [V, 3], first axes of the grids; null for axes at random
  NormalKey Key;                           ///< of the places
};

/// Returns the area of the surface in squares of the spacing, with the sizes.
double AreaInSquares(const PatchSurface& surface, const PatchDistribution& distribution);

/// Draws @p count centers: one at random in each part of the surface with the fraction 1 / count of its area, divided by the
/// square of the size, in the order of the triangles.
std::vector<PatchCenter> DrawPatchCenters(
  const PatchSurface& surface, const PatchDistribution& distribution, std::int64_t count);

} // namespace surfsynth
