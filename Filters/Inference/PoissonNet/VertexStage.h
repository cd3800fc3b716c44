// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Vertex half of a PoissonNet block [Maesumi2025]. Private to the inference.
#pragma once

#include "Inference/Common/ActivationKernels.h"
#include "Inference/PoissonNet/InferenceWeights.h"
#include "Inference/PoissonNet/SolverRows.h"

#include "Core/Common/LargeArray.h"
#include "Core/Common/ScratchPool.h"

#include <cstdint>

namespace surfsynth
{

/// Maps of vertex features, in parallel over tiles of vertices that stay in cache. Features are float32, row-major.
class VertexStage
{
public:
  /// @param vertices number of vertices, V
  /// @param width number of channels of the features, W
  VertexStage(std::int64_t vertices, std::int64_t width);

  /// out = in * matrix + bias; in [V, inputs], out [V, outputs]. Different arrays.
  void Affine(
    const AffineWeights& weights, const float* in, std::int64_t inputs, float* out, std::int64_t outputs) const;
  /// values = GELU(values), [V, W].
  void Gelu(float* values) const;

  /// Inputs of a block's vertex MLP beside the features.
  struct Inputs
  {
    const SolverRows* Solution;            ///< solution of the Poisson equation
    SolverRows::Channels SolutionChannels; ///< map of the solution
    const float* Extra = nullptr;          ///< [V, W] condition, or null: then its contribution is in Bias1
    const float* Products = nullptr;       ///< [V, W] inner products, or null
    std::vector<float> Bias1;              ///< [W], bias of the first affine map
  };
  /// Replaces the features, [V, W], by those after the block.
  void Run(const BlockWeights& weights, const Inputs& inputs, float* features) const;

private:
  static constexpr std::int64_t TileRows = 256;

  template <typename Body>
  void ForTiles(const Body& body) const;

  std::int64_t Vertices;
  std::int64_t Width;
  const ActivationKernels& Kernels;
  std::vector<float> Zeros;                    ///< [W]
  mutable ScratchPool<LargeArray<float>> Pool; ///< two arrays [TileRows, W]
};

} // namespace surfsynth
