// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Nearest patches of an example. Private to the inference.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Finds for each patch the one of the example with the smallest d / (completeness + m), where d is the squared distance and m the
/// smallest squared distance of that example patch from any patch [Granot2022]: patches that nothing looks like yet are
/// preferred, so that all of the example appears. All pairs, in tiles, in parallel; equal ones go to the lowest number.
/// @param coordinates [n, D] in the basis of @p example
/// @param completeness above 0; large values prefer nothing
/// @return [n] numbers of patches of the example
/// @throws Cancelled
std::vector<Index> FindNearestPatches(
  const ExamplePatches& example, const ExamplePatches::Rows& coordinates, float completeness, const Progress& progress);

} // namespace surfsynth
