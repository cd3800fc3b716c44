// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The levels that a texture is learnt from, as tensors. Private to the training.
#pragma once

#include "IO/Datasets/MultiscaleDataset.h"
#include "Learning/Layers/EdgeFeatureTensors.h"
#include "Learning/Layers/RingFeatureTensors.h"

#include <torch/torch.h>

#include <vector>

namespace surfsynth
{

/// One level. Lengths are in units in which the mean edge of level 0 is 2^-level long: edges are about 1 long at each level.
struct GeometricTextureLevelData
{
  FaceTables Tables;
  torch::Tensor Real;            ///< [V, 3], the reference
  torch::Tensor RealFeatures;    ///< [F, 12]
  torch::Tensor Parents;         ///< [E, 2], where the next level has its new vertices
  std::vector<RingTables> Rings; ///< of the neighborhoods that a sliced Wasserstein distance looks at; empty for none
  std::vector<torch::Tensor> RealRingFeatures; ///< [N, 6 R] each
};

struct GeometricTextureLevels
{
  TriangleMesh Template; ///< around the origin, in units of the mean edge of level 0
  torch::Tensor Start;   ///< [V, 3], its points
  std::vector<GeometricTextureLevelData> Data;
};

/// A reference: its levels, and what the training keeps of it.
struct GeometricTextureReference
{
  GeometricTextureLevels Levels;
  SinglePoints ReconstructionNoise; ///< [V of level 0, 3]
  /// Base of the reconstruction, before it is displaced: of levels above 0 the output of the frozen levels for that noise.
  torch::Tensor ReconstructionStart;
  /// Of a flow above level 0: samples of the level before, [V of that level, 3] each.
  std::vector<torch::Tensor> Bases;
};

/// @throws InvalidInput when the dataset is not one of CheckDataset(), or a mesh does not meet
/// GeometricTextureSampler::Requirements().
/// @param rings sizes of neighborhoods, for their tables
GeometricTextureLevels MakeGeometricTextureLevels(
  const MultiscaleDataset& dataset, const torch::Device& device, const std::vector<int>& rings = {});

} // namespace surfsynth
