// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Clusters of the patches of an example. Private to the inference.
#pragma once

#include "Core/Random/CounterNormals.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"

namespace surfsynth
{

/// Groups the patches of an example by k-means of their coordinates, about 256 in a cluster, and sorts them by it. Deterministic,
/// the same bits for every number of threads.
/// @param scale values and coordinates; clusters are set @param key of the patches that the means begin with
void SortIntoClusters(ExamplePatches& scale, const NormalKey& key, const Progress& progress = {});

} // namespace surfsynth
