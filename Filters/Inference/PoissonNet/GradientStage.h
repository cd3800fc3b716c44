// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Face half of a PoissonNet block [Maesumi2025]. Private to the inference.
#pragma once

#include "Inference/Common/ActivationKernels.h"
#include "Inference/PoissonNet/FacePatches.h"
#include "Inference/PoissonNet/InferenceWeights.h"
#include "Inference/PoissonNet/SolverRows.h"

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Common/ScratchPool.h"

#include <memory>

namespace surfsynth
{

/// Vertex features of one mesh, float32 [V, width].
struct VertexFeatures
{
  const float* Values; ///< [V, width]
  /// First affine map of the modulator applied to Values, [V, width], or null without a modulator.
  const float* ModulatorHidden;
};

/// Gradients of vertex features, a complex MLP, and the divergence of its output, on tiles of faces that stay in cache:
/// no array of the size of all faces exists. Threads work on different patches.
class GradientStage
{
public:
  /// @param width number of channels of the features, W
  GradientStage(std::shared_ptr<const FacePatches> patches, std::int64_t width);

  /// Sets the rows of @p target to G^T A h of the gradient features h. When @p products is not null, also sets its
  /// rows, [V, W], to the sums over the faces around of area / 3 times the dot products of mapped features and
  /// gradients. Vertices that no face uses are not written.
  void Run(const VertexFeatures& features, const ComplexMlpWeights& mlp, const ComplexWeights* productMap,
    SolverRows& target, float* products, const Progress& progress) const;

  /// Runs the gradient-domain head: h has three channels, to which the gradients of @p positions, [V, 3], are added.
  /// Writes the sum to @p gradients, [2 F, 3] in the mesh's order of faces, and sets the rows of @p target, which has
  /// 3 channels.
  void RunHead(const VertexFeatures& features, const ComplexMlpWeights& mlp, const float* positions, SolverRows& target,
    float* gradients, const Progress& progress) const;

private:
  /// Number of faces of a tile.
  static constexpr std::int64_t TileRows = 96;

  struct Scratch
  {
    LargeArray<float> Tiles; ///< eight arrays [TileRows, W]
    LargeArray<float> Sums;  ///< up to four arrays [points of a patch, W]
  };
  /// The arrays of one tile, each [TileRows, W].
  struct Tile
  {
    float* Re;
    float* Im;
    float* Sum;
    float* Products[3]; ///< the first two also serve as one array [TileRows, 2 W]
    float* PlainRe;     ///< gradients before the modulation
    float* PlainIm;
  };

  Scratch Borrow() const;
  Tile Divide(const Scratch& scratch) const;
  void Features(std::int64_t first, std::int64_t rows, const VertexFeatures& features, const ComplexMlpWeights& mlp,
    bool keepPlain, const Tile& tile) const;
  void ThreeProducts(const ComplexWeights& weights, std::int64_t rows, const Tile& tile) const;
  void RunPatch(std::int64_t p, const VertexFeatures& features, const ComplexMlpWeights& mlp,
    const ComplexWeights* productMap, SolverRows& target, float* products, float* slots, float* productSlots) const;
  void RunHeadPatch(std::int64_t p, const VertexFeatures& features, const ComplexMlpWeights& mlp,
    const float* positions, SolverRows& target, float* gradients, float* slots) const;

  std::shared_ptr<const FacePatches> Patches;
  std::int64_t Width;
  const ActivationKernels& Kernels;
  std::int64_t MaximumNumberOfPoints = 0; ///< largest number of vertices of a patch
  mutable ScratchPool<Scratch> Pool;
};

} // namespace surfsynth
