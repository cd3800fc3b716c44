// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Nearest patches of an example. Private to the inference.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Search for the patches of an example that are nearest to others, in parallel. Compares a patch with those of the
/// NearestClusters clusters with the least mean of weighted squared distances: with all where there are no more, else with a part of
/// them. A nearest patch in another cluster is missed; then another one is found, which is mostly nearly as near.
class NearestPatches
{
public:
  /// Clusters that a patch is compared with.
  static constexpr std::int64_t NearestClusters = 16;

  /// Keeps a reference to @p example. Without clusters all patches are compared.
  explicit NearestPatches(const ExamplePatches& example);

  /// Divides the squared distances of each patch of the example by @p completeness + m, where m is the smallest one from those of
  /// these patches that are nearest to its cluster [Granot2022]: patches that nothing looks like yet are preferred, so that all of
  /// the example appears.
  /// @param coordinates [n, D] in the basis of the example @param completeness above 0; large values prefer nothing
  /// @throws Cancelled
  void Prefer(const ExamplePatches::Rows& coordinates, float completeness, const Progress& progress = {});

  /// Returns for each patch the number of the nearest one of those of the example that it is compared with, [n]; of equal ones
  /// the lowest.
  /// @param coordinates [n, D] @throws Cancelled
  std::vector<Index> Find(const ExamplePatches::Rows& coordinates, const Progress& progress = {}) const;

private:
  class Block;
  void SetWeights(const Eigen::ArrayXf& weights);
  std::vector<Index> FindIn(const Block& block, const Progress& progress) const;

  const ExamplePatches& Example;
  std::vector<Index> Clusters; ///< [K + 1], see ExamplePatches::Clusters
  /// [D + 2, N]: a row (x, |x|^2, 1) times this is the weighted squared distance of x from each patch of the example.
  ExamplePatches::Rows Forms;
  ExamplePatches::Rows MeanForms; ///< [D + 2, K], their means in the clusters: of the weighted squared distances
};

} // namespace surfsynth
