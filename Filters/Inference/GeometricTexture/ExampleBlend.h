// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places of a target that look like the first or the second of two examples. Private to the inference.
#pragma once

#include "Core/Random/CounterNormals.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Returns thresholds between 0 and 1 at the vertices, [V]: ranks by area of normal numbers smoothed over a length, so that a
/// share of w of the surface has thresholds below w, in islands about as wide as the length.
/// @param length world units, above 0; at most the root of the area is used
/// @throws SolverFailure
Eigen::VectorXf BlendThresholds(const PatchSurface& surface, double length, const NormalKey& key);

/// Returns the centers where the threshold is below the share of the second example; with @p second false the others.
/// @param thresholds [V], those of BlendThresholds() or interpolated @param shares [V], 0 to 1
std::vector<PatchCenter> CentersOfShare(const PatchSurface& surface, const std::vector<PatchCenter>& centers,
  const Eigen::VectorXf& thresholds, const Eigen::VectorXf& shares, bool second);

} // namespace surfsynth
