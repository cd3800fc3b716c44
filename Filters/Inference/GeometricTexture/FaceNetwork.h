// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Network of one level of a geometric texture's generator or discriminator: convolutions over triangles [Hertz2020].
/// Private to the inference.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Inference/GeometricTexture/FaceKernels.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Mean and variance of the channels after one convolution.
struct ChannelStatistics
{
  std::vector<double> Mean;     ///< [C]
  std::vector<double> Variance; ///< [C], at least 0
};

/// Statistics of the channels after each convolution but the last.
using NetworkStatistics = std::vector<ChannelStatistics>;

/// The network of one level. A convolution is max over the neighbours of W [neighbour, self] + b with one W, which is
/// (W_s self + b) + max (W_n neighbour): both products are computed once for each triangle and then gathered, a third
/// of the arithmetic. A norm and a leaky ReLU follow each convolution but the last: an instance norm over all triangles
/// [Ulyanov2016], or one by given statistics, with which an output depends on the triangles nearby alone. Works on
/// tiles that stay in cache, and adds up fixed blocks in order, so that bits do not depend on the threads.
class FaceNetwork
{
public:
  /// Copies the weights of one level.
  /// @param tensors those of ExpectedGeometricTextureTensors(), complete
  /// @param layers GeometricTextureOptions::Layers
  /// @param statistics GeometricTextureModel::Statistics, or empty for instance norms
  /// @param step of a flow, whose statistics are taken; 0 of others
  FaceNetwork(const std::map<std::string, ModelTensor>& tensors, std::int64_t level, std::int64_t layers,
    const std::map<std::string, ModelTensor>& statistics = {}, std::int64_t step = 0);

  /// Output of the last convolution, [F, outputs].
  using Output = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Evaluates the network. The caller keeps the BLAS single-threaded (SingleThreadedBlas).
  /// @param neighbors [F, 3], FaceNeighbors::Faces
  /// @param found receives the statistics of the channels on these triangles, when it is not null
  /// @throws Cancelled
  Output Run(const EdgeFeatureMatrix& features, const TriangleMatrix& neighbors, const Progress& progress = {},
    NetworkStatistics* found = nullptr) const;

private:
  /// Rows of a tile, and of a block of sums.
  static constexpr std::int64_t TileRows = 512;

  /// The first convolution has one map [4, width]; the others have two side by side, [inputs, 2 width].
  struct Layer
  {
    std::int64_t Inputs;
    std::int64_t Width;
    std::vector<float> Matrix;
    std::vector<float> Bias;
  };
  /// (value - Mean) * Scale of each channel.
  struct Norm
  {
    std::vector<float> Mean;
    std::vector<float> Scale;
  };
  /// Sums of each channel, then of its squares, for each tile.
  using Moments = LargeArray<double>;

  Moments FirstMoments(const EdgeFeatureMatrix& features) const;
  static ChannelStatistics Summarise(const Moments& moments, std::int64_t faces, std::int64_t width);
  static Norm NormOf(const ChannelStatistics& statistics);
  /// The norm after convolution @p layer, given or of the moments that @p compute returns.
  template <typename Compute>
  Norm NormAfter(std::size_t layer, std::int64_t faces, NetworkStatistics* found, const Compute& compute) const;
  /// Computes the products of the second convolution from features, and of a later one from the completed products of
  /// the convolution before.
  void MultiplyFeatures(const EdgeFeatureMatrix& features, const Norm& norm, float* products) const;
  void MultiplyCompleted(
    const Layer& layer, const float* completed, std::int64_t faces, const Norm& norm, float* products) const;
  /// Adds the largest products of the neighbors to those of the triangles themselves. @p withMoments: false for no sums
  Moments Complete(const Layer& layer, const TriangleMatrix& neighbors, bool withMoments, float* products) const;

  std::vector<Layer> Layers;
  std::vector<Norm> Given; ///< after each convolution but the last; empty for instance norms
  const FaceKernels& Kernels;
};

} // namespace surfsynth
