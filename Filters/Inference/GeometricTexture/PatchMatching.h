// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Displacements whose patches look like those of an example, at one scale. Private to the inference.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Random/CounterNormals.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <vector>

namespace surfsynth
{

/// Moves displacements so that the distribution of their patches becomes that of the example: descends the sliced Wasserstein
/// distance of batches of both along random directions, by Adam [Kingma2015]. Patches that reach a boundary do not count.
/// @param key seed, scale and stream @param displacement [V, 3], world units
/// @throws Cancelled
void MatchDistribution(const TexturePatches& patches, const ExamplePatches& example, const NormalKey& key,
  double spacing, int iterations, SinglePoints& displacement, const Progress& progress);

/// Patches of a target that are to look like those of an example.
struct PatchShare
{
  const TexturePatches& Patches; ///< at least one
  const ExamplePatches& Example;
};

/// Replaces each patch by the nearest one of its example, and the displacements by those that fit all patches best, up to
/// @p iterations times, until two in a row take less than 0.3 % off the differences: in a power below 2 of the differences, by
/// weights of patches that are smaller the less a patch agrees [Kwatra2005]. Then stretches them until the patches deviate from
/// their mean as widely as those of the example along its principal components. Samples beyond a boundary are those of the patch
/// that was the nearest before.
/// @return the root of the weighted mean square difference of the last patches from the nearest ones, over the amplitude of the
/// example; the largest of the shares
/// @throws Cancelled
double MatchNearest(const PatchSurface& surface, const std::vector<PatchShare>& shares, int iterations,
  SinglePoints& displacement, const Progress& progress);

} // namespace surfsynth
